/** What the pages say, in Japanese and in English. Texts of a study come from the server. */

export const NAMES = { ja: "日本語", en: "English" };

const TEXTS = {
  language: { ja: "ことばを選んでください。", en: "Choose a language." },
  begin: { ja: "はじめて参加する", en: "Begin as a new participant" },
  go_on_by_code: { ja: "コードで続ける", en: "Go on with a code" },
  code: { ja: "あなたのコード", en: "Your code" },
  code_asked: { ja: "コードを入力してください(例:K7Q2M4)。", en: "Enter your code (such as K7Q2M4)." },
  go_on_as: { ja: "コード {code} の続きから始める", en: "Go on as {code}" },
  was_here: { ja: "この端末では、途中の回答があります。", en: "A study was begun on this device and is not finished." },
  or: { ja: "または", en: "or" },
  note_code: {
    ja: "コードを書きとめてください。途中で止まっても、このコードで続きから再開できます。",
    en: "Please write this code down. If anything stops, you can go on from where you were with it.",
  },
  no_names: { ja: "お名前は記録しません。コードだけで保存されます。", en: "No name is kept. Your answers are stored under this code alone." },
  welcome: { ja: "はじめます", en: "Let us begin" },
  welcome_back: { ja: "続きから始めます", en: "You go on where you were" },
  start: { ja: "全画面で始める", en: "Start in full screen" },
  start_plain: { ja: "始める", en: "Start" },
  full_screen: { ja: "全画面にする", en: "Full screen" },
  next: { ja: "次へ", en: "Next" },
  go_on: { ja: "続ける", en: "Go on" },
  trial: { ja: "{trial} / {total}", en: "{trial} of {total}" },
  trial_at_most: { ja: "{trial} 問目(最大 {total} 問)", en: "Trial {trial} (at most {total})" },
  progress: { ja: "進み具合", en: "Progress" },
  practice: { ja: "練習", en: "Practice" },
  consent: { ja: "参加の同意", en: "Consent" },
  questions: { ja: "質問", en: "Questions" },
  rest: { ja: "少し休みましょう", en: "Take a short rest" },
  rest_text: { ja: "準備ができたら続けてください。急ぐ必要はありません。", en: "Go on when you are ready. There is no hurry." },
  done: { ja: "ありがとうございました", en: "Thank you" },
  done_text: { ja: "これで終わりです。回答はすべて保存されました。実験者にお知らせください。", en: "That is all. Every answer is stored. Please tell the experimenter." },
  declined: { ja: "わかりました", en: "That is quite all right" },
  declined_text: { ja: "参加されないということを記録しました。ほかには何も記録していません。実験者にお知らせください。", en: "You chose not to take part. Nothing else is kept. Please tell the experimenter." },
  aborted: { ja: "ここで終わりです", en: "The session has ended" },
  aborted_text: { ja: "実験者がセッションを終了しました。ここまでの回答は保存されています。", en: "The experimenter ended the session. What you answered so far is stored." },
  card_title: { ja: "画面の大きさを合わせます", en: "Match the size of the screen" },
  card_lying: {
    ja: "ICカードや運転免許証など、ふつうの大きさのカードを横向きにして画面にあて、左上の角を枠に合わせてください。",
    en: "Lay a bank card, a student card or a driving licence on the screen, its corner in the corner of the frame.",
  },
  card_standing: {
    ja: "ICカードや運転免許証など、ふつうの大きさのカードを縦向きにして画面にあて、左上の角を枠に合わせてください。",
    en: "Hold a bank card, a student card or a driving licence upright to the screen, its corner in the corner of the frame.",
  },
  card_text: {
    ja: "右の線がカードの右端に重なるまで動かします(矢印キーでも動きます)。",
    en: "Drag the line at the right to the right edge of the card, or move it with the arrow keys.",
  },
  card_slider: { ja: "カードの幅", en: "Width of the card" },
  card_here: { ja: "カードをここに", en: "Card here" },
  card_fits: { ja: "ぴったり合いました", en: "It fits exactly" },
  card_move_first: { ja: "線をカードの端に合わせてください。", en: "Move the line to the edge of your card first." },
  card_shorter: { ja: "狭く", en: "Narrower" },
  card_longer: { ja: "広く", en: "Wider" },
  too_small: { ja: "この画面は小さいため、{asked}mmのものを{drawn}mmで表示しています。", en: "This screen is small: what should be {asked} mm is shown at {drawn} mm." },
  turn: { ja: "端末を横向きにすると正しい大きさになります。", en: "Turned sideways, the device can show the right size." },
  play: { ja: "{name}を再生", en: "Play {name}" },
  play_one: { ja: "再生", en: "Play" },
  play_both: { ja: "AとBを順に再生", en: "Play A, then B" },
  playing: { ja: "再生中", en: "playing" },
  played: { ja: "再生済み", en: "played" },
  loading: { ja: "読み込み中…", en: "Loading …" },
  area: { ja: "領域 {name}", en: "Area {name}" },
  area_label: { ja: "領域{name}。指で目標を追ってなぞります。キーボードではスペースキーを押し続けます。", en: "Area {name}. Stroke it with a finger, following the target. On a keyboard, hold the space bar." },
  area_done: { ja: "なぞりました", en: "stroked" },
  image: { ja: "評価する画像", en: "The image to be judged" },
  image_of: { ja: "{name}の画像", en: "Image of {name}" },
  scale: { ja: "目盛りのない線。触れて印をつけます。", en: "A line without marks. Touch it to set your mark." },
  scale_touch: { ja: "線に触れて印をつけてください", en: "Touch the line to set your mark" },
  not_marked: { ja: "印はまだありません", en: "not marked yet" },
  marked: { ja: "左端から {percent} %", en: "{percent} % from the left end" },
  number: { ja: "数", en: "Number" },
  optional: { ja: "(任意)", en: "(optional)" },
  need_play: { ja: "先に{names}を再生してください。", en: "Play {names} first." },
  need_play_one: { ja: "先に再生してください。", en: "Play it first." },
  need_stroke: { ja: "先に{names}をなぞってください。", en: "Stroke {names} first." },
  need_answer: { ja: "回答を選んでください。", en: "Choose an answer first." },
  need_answers: { ja: "あと{count}個の回答が必要です。", en: "{count} more to answer." },
  need_mark: { ja: "線に印をつけてください。", en: "Set a mark on each line first." },
  need_number: { ja: "数を入力してください。", en: "Enter a number first." },
  bad_number: { ja: "{low}以上の数を入力してください。", en: "Enter a number of at least {low}." },
  bad_positive: { ja: "0より大きい数を入力してください。", en: "Enter a number above 0." },
  bad_between: { ja: "{low}から{high}までの数を入力してください。", en: "Enter a number from {low} to {high}." },
  and: { ja: "と", en: " and " },
  sending: { ja: "送信中…", en: "Sending …" },
  kept: {
    ja: "つながりません。回答はこの端末に保存されています。つながりしだい自動で送信します。そのままお待ちください。",
    en: "There is no connection. Your answer is kept on this device, and is sent by itself as soon as there is one. Please wait.",
  },
  waiting: { ja: "つながりません。自動でつなぎ直しています。そのままお待ちください。", en: "There is no connection. This page tries again by itself. Please wait." },
  no_ticket: { ja: "このページは使えません。実験者にお知らせください。", en: "This page cannot be used. Please tell the experimenter." },
  no_audio: { ja: "このブラウザーでは音を再生できません。実験者にお知らせください。", en: "This browser cannot play sound. Please tell the experimenter." },
  no_sound: { ja: "刺激を再生できませんでした。もう一度お試しください。続くときは実験者にお知らせください。", en: "The stimulus could not be played. Try again; if it happens again, tell the experimenter." },
  no_code: { ja: "コードを入力してください。", en: "Enter your code first." },
  refused: { ja: "受け付けられませんでした:{error}", en: "Not accepted: {error}" },
  speak: { ja: "言語", en: "Language" },
};

/**
 * Return a text, `{name}` replaced by a value.
 * @param {"ja"|"en"} language
 * @param {string} key
 * @param {Object<string, string|number>} [values]
 */
export function say(language, key, values = {}) {
  const text = TEXTS[key][language] ?? TEXTS[key].en;
  return text.replace(/\{(\w+)\}/g, (whole, name) => (name in values ? String(values[name]) : whole));
}

/** Return names joined as the language does. */
export function joined(language, names) {
  const comma = language === "ja" ? "、" : ", ";
  if (names.length < 2) return names.join("");
  return names.slice(0, -1).join(comma) + say(language, "and") + names[names.length - 1];
}
