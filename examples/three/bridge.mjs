// Passes what comes by UDP on to every page that follows: node bridge.mjs [UDP port] [WebSocket port]
import dgram from "node:dgram";
import { WebSocketServer } from "ws";

const [udpPort = "9000", webPort = "9001"] = process.argv.slice(2);
const pages = new WebSocketServer({ host: "127.0.0.1", port: Number(webPort) });
const udp = dgram.createSocket("udp4");
udp.on("message", (datagram) => {
    for (const page of pages.clients) page.send(datagram, { binary: true });
});
udp.bind(Number(udpPort), "127.0.0.1", () => {
    console.log(`udp ${udp.address().port}, ws://127.0.0.1:${pages.address().port}`);
});
