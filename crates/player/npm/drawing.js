/** The three.js objects of a face: one geometry, its materials, and a mesh for each place where it is drawn. */

/** The images of a rig's textures, as three.js takes them. */
export function images(wasm, facts) {
    // three.js flips no ImageBitmap, and takes colours as they are in the file.
    const options = { imageOrientation: "flipY", premultiplyAlpha: "none", colorSpaceConversion: "none" };
    return Promise.all(facts.textures.map((type, i) => createImageBitmap(new Blob([wasm.texture(i)], { type }), options)));
}

/** The geometry, at rest. */
export function geometryOf(THREE, wasm, facts) {
    const geometry = new THREE.BufferGeometry();
    geometry.name = facts.name;
    const rest = wasm.rest();
    const indices = wasm.indices();
    const isShort = rest.length / 3 <= 65536;
    geometry.setIndex(new THREE.BufferAttribute(isShort ? new Uint16Array(indices) : indices, 1));
    geometry.setAttribute("position", new THREE.BufferAttribute(rest, 3));
    const uvs = wasm.uvs();
    if (uvs) geometry.setAttribute("uv", new THREE.BufferAttribute(uvs, 2));
    geometry.computeVertexNormals();
    geometry.computeBoundingBox();
    geometry.computeBoundingSphere();
    // A face moves, and what is drawn is not in these arrays.
    geometry.boundingBox.expandByScalar(0.25 * geometry.boundingSphere.radius);
    geometry.boundingSphere.radius *= 1.25;
    if (facts.groups.length > 1) {
        facts.groups.forEach(({ first, count }, i) => geometry.addGroup(3 * first, 3 * count, i));
    }
    return geometry;
}

/** A material for each group of triangles. */
export function materialsOf(THREE, facts, bitmaps) {
    const textures = bitmaps.map((bitmap) => {
        const texture = new THREE.Texture(bitmap);
        texture.flipY = false;
        texture.colorSpace = THREE.SRGBColorSpace;
        texture.wrapS = texture.wrapT = THREE.RepeatWrapping;
        texture.needsUpdate = true;
        return texture;
    });
    const materials = facts.groups.map(({ material }) => {
        const look = facts.materials[material ?? facts.materials.length - 1];
        const made = new THREE.MeshStandardMaterial({
            name: look.name,
            map: look.texture === null ? null : textures[look.texture],
            roughness: look.roughness,
            metalness: look.metalness,
            opacity: look.opacity,
            transparent: look.transparency === "blend",
            alphaTest: look.cutoff ?? 0,
            side: THREE.DoubleSide,
        });
        made.color.setRGB(...look.color, THREE.LinearSRGBColorSpace);
        return made;
    });
    return materials.length === 1 ? materials[0] : materials;
}
