/** Texts of the pages in Japanese and English. Texts of a study come from the server. */

export const NAMES = { ja: "日本語", en: "English" };

const TEXTS = {
  language: { ja: "ことばを選んでください。", en: "Choose a language." },
  begin: { ja: "はじめて参加する", en: "Begin as a new participant" },
  go_on_by_code: { ja: "コードで続ける", en: "Continue with a code" },
  code: { ja: "あなたのコード", en: "Your code" },
  code_asked: { ja: "コードを入力してください(例:K7Q2M4)。", en: "Enter your code (for example K7Q2M4)." },
  go_on_as: { ja: "コード {code} の続きから始める", en: "Continue as {code}" },
  was_here: { ja: "この端末では、途中の回答があります。", en: "A study was started on this device and is not finished." },
  or: { ja: "または", en: "or" },
  note_code: {
    ja: "コードを書きとめてください。途中で止まっても、このコードで続きから再開できます。",
    en: "Please write this code down. If anything interrupts you, it lets you continue where you stopped.",
  },
  no_names: { ja: "お名前は記録しません。コードだけで保存されます。", en: "Your name is not recorded. Your answers are stored under this code only." },
  welcome: { ja: "はじめます", en: "Let's begin" },
  welcome_back: { ja: "続きから始めます", en: "Continue where you stopped" },
  start: { ja: "全画面で始める", en: "Start in full screen" },
  start_plain: { ja: "始める", en: "Start" },
  full_screen: { ja: "全画面にする", en: "Full screen" },
  next: { ja: "次へ", en: "Next" },
  go_on: { ja: "続ける", en: "Continue" },
  trial: { ja: "{trial} / {total}", en: "{trial} of {total}" },
  trial_at_most: { ja: "{trial} 問目(最大 {total} 問)", en: "Trial {trial} (at most {total})" },
  progress: { ja: "進み具合", en: "Progress" },
  practice: { ja: "練習", en: "Practice" },
  consent: { ja: "参加の同意", en: "Consent" },
  questions: { ja: "質問", en: "Questions" },
  rest: { ja: "少し休みましょう", en: "Take a short rest" },
  rest_text: { ja: "準備ができたら続けてください。急ぐ必要はありません。", en: "Continue when you are ready. There is no hurry." },
  done: { ja: "ありがとうございました", en: "Thank you" },
  done_text: { ja: "これで終わりです。回答はすべて保存されました。実験者にお知らせください。", en: "You have finished. All your answers are stored. Please tell the experimenter." },
  declined: { ja: "わかりました", en: "That is fine" },
  declined_text: { ja: "参加されないということを記録しました。ほかには何も記録していません。実験者にお知らせください。", en: "Your decision not to take part is recorded. Nothing else is stored. Please tell the experimenter." },
  aborted: { ja: "ここで終わりです", en: "The session has ended" },
  aborted_text: { ja: "実験者がセッションを終了しました。ここまでの回答は保存されています。", en: "The experimenter ended the session. Your answers so far are stored." },
  card_title: { ja: "画面の大きさを合わせます", en: "Adjust to the size of your screen" },
  card_lying: {
    ja: "ICカードや運転免許証など、ふつうの大きさのカードを横向きにして画面にあて、左上の角を枠に合わせてください。",
    en: "Lay a bank card, student card or driving licence on the screen, with its top left corner in the corner of the frame.",
  },
  card_standing: {
    ja: "ICカードや運転免許証など、ふつうの大きさのカードを縦向きにして画面にあて、左上の角を枠に合わせてください。",
    en: "Hold a bank card, student card or driving licence upright against the screen, with its top left corner in the corner of the frame.",
  },
  card_text: {
    ja: "右の線がカードの右端に重なるまで動かします(矢印キーでも動きます)。",
    en: "Drag the line on the right to the right edge of the card, or move it with the arrow keys.",
  },
  card_slider: { ja: "カードの幅", en: "Width of the card" },
  card_here: { ja: "カードをここに", en: "Place the card here" },
  card_fits: { ja: "ぴったり合いました", en: "It fits" },
  card_move_first: { ja: "線をカードの端に合わせてください。", en: "Move the line to the edge of your card first." },
  card_shorter: { ja: "狭く", en: "Narrower" },
  card_longer: { ja: "広く", en: "Wider" },
  too_small: { ja: "この画面は小さいため、{asked}mmのものを{drawn}mmで表示しています。", en: "This screen is small: {asked} mm is shown as {drawn} mm." },
  turn: { ja: "端末を横向きにすると正しい大きさになります。", en: "Turn the device sideways to see the right size." },
  play: { ja: "{name}を再生", en: "Play {name}" },
  play_one: { ja: "再生", en: "Play" },
  play_both: { ja: "AとBを順に再生", en: "Play A, then B" },
  playing: { ja: "再生中", en: "playing" },
  played: { ja: "再生済み", en: "played" },
  loading: { ja: "読み込み中…", en: "Loading …" },
  area: { ja: "領域 {name}", en: "Area {name}" },
  area_label: { ja: "領域{name}。指で目標を追ってなぞります。キーボードではスペースキーを押し続けます。", en: "Area {name}. Stroke it with a finger, following the target. On a keyboard, hold the space bar." },
  area_done: { ja: "なぞりました", en: "stroked" },
  image: { ja: "評価する画像", en: "Image to rate" },
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
  need_stroke_one: { ja: "先になぞってください。", en: "Stroke it first." },
  need_answer: { ja: "回答を選んでください。", en: "Choose an answer first." },
  need_answers: { ja: "あと{count}個の回答が必要です。", en: "{count} questions left to answer." },
  need_mark: { ja: "線に印をつけてください。", en: "Set a mark on each line first." },
  need_number: { ja: "数を入力してください。", en: "Enter a number first." },
  bad_number: { ja: "{low}以上の数を入力してください。", en: "Enter a number of {low} or more." },
  bad_positive: { ja: "0より大きい数を入力してください。", en: "Enter a number above 0." },
  bad_between: { ja: "{low}から{high}までの数を入力してください。", en: "Enter a number from {low} to {high}." },
  and: { ja: "と", en: " and " },
  sending: { ja: "送信中…", en: "Sending …" },
  kept: {
    ja: "つながりません。回答はこの端末に保存されています。つながりしだい自動で送信します。そのままお待ちください。",
    en: "There is no connection. Your answer is stored on this device and will be sent automatically. Please wait.",
  },
  waiting: { ja: "つながりません。自動でつなぎ直しています。そのままお待ちください。", en: "There is no connection. This page keeps trying to reconnect. Please wait." },
  no_ticket: { ja: "このページは使えません。実験者にお知らせください。", en: "This page cannot be used. Please tell the experimenter." },
  no_audio: { ja: "このブラウザーでは音を再生できません。実験者にお知らせください。", en: "This browser cannot play sound. Please tell the experimenter." },
  no_sound: { ja: "刺激を再生できませんでした。もう一度お試しください。続くときは実験者にお知らせください。", en: "The stimulus could not be played. Please try again. If this happens again, tell the experimenter." },
  refused: { ja: "受け付けられませんでした:{error}", en: "Not accepted: {error}" },
};

/** Return a text, with each `{name}` replaced by its value. */
export function say(language, key, values = {}) {
  const text = TEXTS[key][language] ?? TEXTS[key].en;
  return text.replace(/\{(\w+)\}/g, (whole, name) => (name in values ? String(values[name]) : whole));
}

/** Return names as a list in the language. */
export function joined(language, names) {
  const comma = language === "ja" ? "、" : ", ";
  if (names.length < 2) return names.join("");
  return names.slice(0, -1).join(comma) + say(language, "and") + names[names.length - 1];
}
