// The words of the page. The explanation is in several languages (lab/text). The laboratory is in English, as are the
// engine's names, descriptions and messages.

const TEXTS = JSON.parse(document.getElementById("texts").textContent);
/** The language in the address, else the reader's first available language, else English. */
const CHOSEN = [new URLSearchParams(location.search).get("language"), ...navigator.languages]
  .map((name) => name?.slice(0, 2)).find((name) => Object.hasOwn(TEXTS, name)) ?? "en";
/** Whether the address asks for the explanation. */
const isExploring = () => /^(#|#screen=\d)?$/.test(location.hash);
const languageNow = () => (isExploring() ? CHOSEN : "en");
const LANGUAGE = languageNow();

/** A text by its key, with values for its {placeholders}. */
function say(key, values = {}) {
  const text = TEXTS[LANGUAGE][key] ?? TEXTS.en[key];
  if (text === undefined) throw new Error(`there is no text ${key}`);
  return text.replace(/\{(\w+)\}/g, (_, name) => values[name]);
}

/** Fills the elements that name their text, label or title, and offers the languages. */
function fillTexts(find) {
  document.documentElement.lang = LANGUAGE;
  for (const [name, attribute] of [["say", "textContent"], ["sayLabel", "ariaLabel"], ["sayTitle", "title"]]) {
    const mark = `[data-${name.replace(/[A-Z]/, (letter) => `-${letter.toLowerCase()}`)}]`;
    for (const element of document.querySelectorAll(mark)) element[attribute] = say(element.dataset[name]);
  }
  const languages = Object.entries(TEXTS).map(([name, texts]) => Object.assign(new Option(texts.language, name),
      { lang: name }));
  find("language").append(...languages);
  find("language").value = CHOSEN;
  // The part of the address after # names the screen, which stays.
  find("language").addEventListener("change", ({ target }) => (location.search = `language=${target.value}`));
}
