// The page: puts its parts together around one websocket.
import { connect } from './connection.js';
import { choices } from './choices.js';
import { driving } from './driving.js';
import { tiles } from './tiles.js';

const status = document.getElementById('status');

function say(sentence, problem = false) {
  status.textContent = sentence;
  status.classList.toggle('problem', problem);
}

const connection = connect({
  opened() { say('Live'); views.look(); },
  closed() { say('The server does not answer; trying again …', true); drive.stop(); views.lost(); },
  frame(head, jpeg) { views.frame(head, jpeg); },
  said(message) {
    if (message.state) { drive.allow(message.state.drive); choose.show(message.state); }
    if (message.problem) say(message.problem, true);
    if (message.without) views.without(message.without, message.why);
  },
});
const views = tiles(connection.send);
const drive = driving(connection.send);
const choose = choices(connection.send, say);
