// The page: puts its parts together around one websocket.
import { connect } from './connection.js';
import { choices } from './choices.js';
import { driving } from './driving.js';
import { tiles } from './tiles.js';

const SAID_MS = 8000;
const status = document.getElementById('status');
let forget = null;
let state = null;

// For a while, unless it is to last.
function say(sentence, problem = false, lasts = false) {
  status.textContent = sentence;
  status.classList.toggle('problem', problem);
  clearTimeout(forget);
  if (!lasts) forget = setTimeout(() => say('Live', false, true), SAID_MS);
}

const connection = connect({
  opened() { say('Live', false, true); views.look(); },
  closed() { say('The server does not answer; trying again …', true, true); drive.allow(false); views.lost(); },
  frame(head, jpeg) { views.frame(head, jpeg); },
  said(message) {
    if (message.state) { state = message.state; drive.allow(state.drive); choose.show(state); }
    if (message.problem) { say(message.problem, true); choose.show(state); }
    if (message.without) views.without(message.without, message.why);
  },
});
const views = tiles(connection.send);
const drive = driving(connection.send);
const choose = choices(connection.send, say);
