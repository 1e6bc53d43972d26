/** What goes to the server and comes back; an answer is kept here until the server has it. */

const FIRST_WAIT_MS = 1000;
const LONGEST_WAIT_MS = 8000;

/** An answer of the server that is no success. */
export class Refused extends Error {
  constructor(status, text) {
    super(text);
    this.status = status;
  }
}

/** In use by another, asked too often: later it may do. */
const LATER = [423, 429];
/** Whether trying again can help: the net is away, the server restarts, or it is busy. */
export const passes = (error) => !(error instanceof Refused) || error.status >= 500 || LATER.includes(error.status);

/**
 * Ask the server once.
 * @param {string} path
 * @param {any} [body] sent as JSON by POST; else it is a GET
 * @returns {Promise<any>}
 */
export async function ask(path, body) {
  const response = await fetch(path, body === undefined ? { cache: "no-store" } : posted(body));
  const text = await response.text();
  let value = null;
  try {
    value = JSON.parse(text);
  } catch {
    // Not of this server's making: a proxy, or an error page.
  }
  if (!response.ok || value === null) throw new Refused(response.ok ? 502 : response.status, value?.error ?? response.statusText);
  return value;
}

function posted(body) {
  return { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body), cache: "no-store" };
}

/** Ask for a file's bytes. */
export async function bytes(path) {
  const response = await fetch(path, { cache: "no-store" });
  if (response.ok) return response.arrayBuffer();
  const told = await response.json().catch(() => null);
  throw new Refused(response.status, told?.error ?? response.statusText);
}

/**
 * Try until it succeeds or cannot succeed.
 * @param {() => Promise<any>} attempt
 * @param {(away: boolean, why: string) => void} told whether it is tried again, and what the server said of why
 */
export async function insist(attempt, told) {
  for (let wait = FIRST_WAIT_MS; ; wait = Math.min(2 * wait, LONGEST_WAIT_MS)) {
    try {
      const value = await attempt();
      told(false, "");
      return value;
    } catch (error) {
      if (!passes(error)) {
        told(false, "");
        throw error;
      }
      told(true, error instanceof Refused && error.status !== 502 ? error.message : "");
      await elapsed(wait);
    }
  }
}

/** Wait, or until the net is back. */
function elapsed(ms) {
  return new Promise((resolve) => {
    const done = () => {
      clearTimeout(timer);
      window.removeEventListener("online", done);
      resolve();
    };
    const timer = setTimeout(done, ms);
    window.addEventListener("online", done);
  });
}

/** The answer that the server has not acknowledged, kept over a reload. */
export class Outbox {
  constructor(ticket) {
    this.key = `tactogram.answer.${ticket}`;
    this.held = null;
  }

  /** Keep an answer. */
  keep(body) {
    this.held = body;
    try {
      localStorage.setItem(this.key, JSON.stringify(body));
    } catch {
      // Without storage it is kept as long as the page is open.
    }
  }

  /** Return what is kept, or null. */
  kept() {
    if (this.held) return this.held;
    try {
      return JSON.parse(localStorage.getItem(this.key) ?? "null");
    } catch {
      return null;
    }
  }

  /** Forget it: the server has it. */
  clear() {
    this.held = null;
    try {
      localStorage.removeItem(this.key);
    } catch {
      // Nothing was kept.
    }
  }
}
