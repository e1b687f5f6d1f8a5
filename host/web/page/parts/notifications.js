// What the host has told lately: the newest five, the others on demand.
import { timeOfDay } from "../words/times.js";
import { h } from "./dom.js";
import { details } from "./notices.js";

const SHOWN = 5;

export function notificationList(notifications) {
  if (notifications.length === 0) return null;
  const newest = [...notifications].reverse();
  const item = ({ utc, text }) => h("li", {}, h("time", { datetime: utc }, timeOfDay(utc)), ` ${text}`);
  return [
    h("h2", {}, "Messages"),
    h("ol", { class: "plain-list" }, newest.slice(0, SHOWN).map(item)),
    newest.length > SHOWN &&
      details(
        `${newest.length - SHOWN} earlier`,
        h("ol", { class: "plain-list" }, newest.slice(SHOWN).map(item)),
      ),
  ];
}
