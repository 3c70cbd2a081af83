// The page: connects its parts to the websocket.
import { connect } from './connection.js';
import { choices } from './choices.js';
import { driving } from './driving.js';
import { filming } from './filming.js';
import { tiles } from './tiles.js';
import { prepare } from './video.js';

const MESSAGE_MS = 8000;
const status = document.getElementById('status');
let timer = null;
let state = null;

// Show a sentence for MESSAGE_MS, or until the next one.
function say(sentence, problem = false, stays = false) {
  status.textContent = sentence;
  status.classList.toggle('problem', problem);
  clearTimeout(timer);
  if (!stays) timer = setTimeout(() => say('Live', false, true), MESSAGE_MS);
}

await prepare();
const connection = connect({
  opened() { say('Live', false, true); views.requestFrames(); },
  closed() { say('The server does not answer. Reconnecting …', true, true); drive.allow(false); views.lost(); },
  frame(head, data) { views.frame(head, data); },
  received(message) {
    if (message.state) { state = message.state; drive.allow(state.drive); choose.show(state); views.advise(state.advice); }
    if (message.problem) { say(message.problem, true); choose.show(state, true); }
    if (message.without) views.showProblem(message.without, message.why);
  },
});
const views = tiles(connection.send);
const drive = driving(connection.send);
const choose = choices(connection.send, say);
filming(say);
