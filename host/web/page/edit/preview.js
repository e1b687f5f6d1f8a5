// Asks for the newest only: has one question under way at a time, the next one a moment after it was wanted or when the one
// before is answered, and drops answers to what is no longer asked. Pure but for the timer and the question, which are given.

/**
 * ask(text) -> promise; answered(answer, text), failed(error, text): for the newest only; busy(whether).
 */
export function createNewestOnly({ ask, answered, failed, busy = () => {}, delay_ms = 50, later = setTimeout, never = clearTimeout }) {
  let wanted = null;
  let timer = null;
  let underWay = false;

  async function send() {
    timer = null;
    if (underWay || wanted === null) return;
    const text = wanted;
    underWay = true;
    let outcome;
    try {
      const answer = await ask(text);
      outcome = () => answered(answer, text);
    } catch (error) {
      outcome = () => failed(error, text);
    }
    underWay = false;
    if (text === wanted) {
      wanted = null;
      busy(false);
      outcome();
    } else if (timer === null && wanted !== null) {
      send();
    }
  }

  return {
    want(text) {
      wanted = text;
      busy(true);
      if (timer === null && !underWay) timer = later(send, delay_ms);
    },
    /// What is under way is no longer of interest.
    forget() {
      wanted = null;
      if (timer !== null) never(timer);
      timer = null;
      busy(false);
    },
    pending: () => wanted !== null,
  };
}
