// Shows what the server says, as it says it.
const socket = new WebSocket(`ws://${location.host}/socket`, "flotilla.console.v1");
const token = new URLSearchParams(location.hash.slice(1)).get("token");
socket.onopen = () => token && socket.send(JSON.stringify({ id: 1, do: "hello", token }));
socket.onmessage = ({ data }) => {
  document.getElementById("snapshot").textContent = JSON.stringify(JSON.parse(data), null, 1);
};
socket.onclose = () => {
  document.title = "Flotilla: not connected";
};
