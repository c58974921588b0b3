// Reads USD files with three.js, which is in the folder of the first argument, and prints what each has as JSON.

import { readFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

const [modules, ...files] = process.argv.slice(2);
const load = (path) => import(pathToFileURL(join(modules, "three", path)));
const { USDLoader } = await load("examples/jsm/loaders/USDLoader.js");

for (const file of files) {
  const bytes = readFileSync(file);
  const data = file.endsWith("a") ? bytes.toString() : new Uint8Array(bytes).buffer;
  const scene = new USDLoader().parse(data);
  scene.updateMatrixWorld(true);
  const read = { corners: 0, min: null, max: null, materials: [] };
  scene.traverse((object) => {
    if (!object.isMesh) return;
    object.geometry.computeBoundingBox();
    const box = object.geometry.boundingBox.clone().applyMatrix4(object.matrixWorld);
    read.corners += object.geometry.attributes.position.count;
    read.min = box.min.toArray();
    read.max = box.max.toArray();
    const round = (color) => color.toArray().map((part) => Math.round(part * 1e6) / 1e6);
    read.materials = [object.material].flat().map((material) => round(material.color));
  });
  console.log(JSON.stringify(read));
}
