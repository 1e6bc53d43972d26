/** Requests to the server; an answer is stored here until the server has it. */

const FIRST_WAIT_MS = 1000;
const LONGEST_WAIT_MS = 8000;

/** A response of the server that is not a success. */
export class Refused extends Error {
  constructor(status, text) {
    super(text);
    this.status = status;
  }
}

/** Of a response that is not this server's. */
const UNREACHABLE = 502;
/** In use by another participant, or too many attempts: worth trying later. */
const LATER = [423, 429];
/** Whether trying again can help: the network is down, the server restarts, or it is busy. */
export const passes = (error) => !(error instanceof Refused) || error.status >= 500 || LATER.includes(error.status);

/** Return the status of a refusal; 0 if the server was not reached. */
export const statusOf = (error) => (error instanceof Refused && error.status !== UNREACHABLE ? error.status : 0);

/** Return the JSON of one request: a POST of `body`, or a GET without one. */
export async function ask(path, body) {
  const response = await fetch(path, body === undefined ? { cache: "no-store" } : posted(body));
  const text = await response.text();
  let value = null;
  try {
    value = JSON.parse(text);
  } catch {
    // Not from this server: a proxy, or an error page.
  }
  if (!response.ok || value === null) throw new Refused(response.ok ? UNREACHABLE : response.status, value?.error ?? response.statusText);
  return value;
}

function posted(body) {
  return { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body), cache: "no-store" };
}

/** Return a file's bytes. */
export async function bytes(path) {
  const response = await fetch(path, { cache: "no-store" });
  if (response.ok) return response.arrayBuffer();
  const failure = await response.json().catch(() => null);
  throw new Refused(response.status, failure?.error ?? response.statusText);
}

/**
 * Try until it succeeds or cannot succeed.
 * @param {() => Promise<any>} attempt
 * @param {(away: boolean, status: number) => void} report whether it will try again, and the status of the refusal
 */
export async function insist(attempt, report) {
  for (let wait = FIRST_WAIT_MS; ; wait = Math.min(2 * wait, LONGEST_WAIT_MS)) {
    try {
      const value = await attempt();
      report(false, 0);
      return value;
    } catch (error) {
      if (!passes(error)) {
        report(false, 0);
        throw error;
      }
      report(true, statusOf(error));
      await elapsed(wait);
    }
  }
}

/** Wait, or until the network is back. */
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

/** The answer that the server has not acknowledged; it survives a reload. */
export class Outbox {
  constructor(ticket) {
    this.key = `tactogram.answer.${ticket}`;
    this.held = null;
  }

  keep(body) {
    this.held = body;
    try {
      localStorage.setItem(this.key, JSON.stringify(body));
    } catch {
      // Without storage it lasts as long as the page is open.
    }
  }

  /** Return the stored answer, or null. */
  kept() {
    if (this.held) return this.held;
    try {
      return JSON.parse(localStorage.getItem(this.key) ?? "null");
    } catch {
      return null;
    }
  }

  clear() {
    this.held = null;
    try {
      localStorage.removeItem(this.key);
    } catch {
      // Nothing was kept.
    }
  }
}
