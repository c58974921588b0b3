// What a model in three.js shows in a frame. For three.js itself and for programs that draw with it, each with its own copy of it.

// Positions and normals of all meshes, one after the other, as the vertex shader morphs them: in the space around the model, since
// viewers move the model to their middle. A normal may have any length.
export function shown(model) {
    const meshes = [];
    model.parent.updateWorldMatrix(true, true);
    model.traverse((object) => object.isMesh && object.geometry.attributes.position && meshes.push(object));
    const around = model.parent.matrixWorld.clone().invert();
    const toAround = around.clone();
    const [point, part, normalMatrix] = [model.position.clone(), model.position.clone(), model.normalMatrix.clone()];
    const [positions, normals] = [[], []];
    for (const mesh of meshes) {
        const { position, normal } = mesh.geometry.attributes;
        const targets = mesh.geometry.morphAttributes.normal;
        toAround.multiplyMatrices(around, mesh.matrixWorld);
        normalMatrix.getNormalMatrix(toAround);
        for (let v = 0; v < position.count; v++) {
            mesh.getVertexPosition(v, point).applyMatrix4(toAround);
            positions.push(point.x, point.y, point.z);
            if (!normal) continue;
            point.fromBufferAttribute(normal, v);
            (targets ? mesh.morphTargetInfluences : []).forEach((influence, target) => {
                if (influence !== 0) point.addScaledVector(part.fromBufferAttribute(targets[target], v), influence);
            });
            point.applyMatrix3(normalMatrix);
            normals.push(point.x, point.y, point.z);
        }
    }
    return { positions, normals: normals.length === positions.length ? normals : null };
}

export function materials(model) {
    const used = new Set();
    model.traverse((object) => object.isMesh && [object.material].flat().forEach((material) => used.add(material)));
    return [...used].map((material) => {
        const image = material.map?.image;
        const texture = image?.width ? [image.width, image.height] : null;
        return { name: material.name, colour: texture ? null : material.color.toArray(), texture };
    });
}
