"""The tab Handles: by count, from a take, clicked, moved, mirrored."""

from __future__ import annotations

import bpy
import numpy as np

from support import Case, choose, demo, load, module


class Handles(Case):
    def labels(self, face: bpy.types.Object) -> list[str]:
        return [item.name for item in face.rhytid.handles]

    def test_by_count(self) -> None:
        face = self.face()
        face.rhytid.count = 30
        bpy.ops.rhytid.handles_by_count()
        self.assertTrue(25 <= len(face.rhytid.handles) <= 30)
        bpy.ops.rhytid.solve()
        self.assertEqual(module("store").rig(face).labels, self.labels(face))

    def test_from_a_take_they_are_where_they_were(self) -> None:
        face = self.face()
        expected = dict(zip(self.labels(face), module("handles").positions_of(face)))
        bpy.ops.rhytid.handles_from_take(filepath=str(demo / "performance.csv"))
        found = dict(zip(self.labels(face), module("handles").positions_of(face)))
        self.assertEqual(sorted(found), sorted(expected))
        distances = [np.linalg.norm(found[label] - expected[label]) for label in found]
        # In centimetres.
        self.assertLess(np.median(distances), 0.05)
        face.rhytid.handles.clear()
        self.fails("no file is chosen", bpy.ops.rhytid.handles_from_take)
        self.fails("none.c3d", bpy.ops.rhytid.handles_from_take, filepath=str(self.folder / "none.c3d"))

    def test_points_inside_triangles_keep_their_weights(self) -> None:
        face, project = self.face(), module("project")
        corners = tuple(face.data.polygons[7].vertices[:3])
        place = project.Handle("cheek", corners, (0.5, 0.3, 0.2))
        module("handles").put_all(face, [place])
        found = face.rhytid.handles[0].place
        self.assertEqual((found.label, found.vertices), ("cheek", corners))
        self.assertTrue(np.allclose(found.weights, place.weights, atol=1e-6))
        path = self.folder / "markers.csv"
        project.write_handles(path, [found, project.Handle("chin", (4,))])
        again = project.read_handles(path)
        self.assertEqual((again[0].vertices, again[1].vertices, again[1].weights), (corners, (4,), (1.0,)))

    def test_at_the_selected_vertex(self) -> None:
        face = load(demo / "neutral.obj")
        self.fails("vertices are selected, expected one", bpy.ops.rhytid.add_handle)
        for elements in (face.data.polygons, face.data.edges, face.data.vertices):
            elements.foreach_set("select", np.zeros(len(elements), bool))
        face.data.vertices[40].select = True
        bpy.ops.rhytid.add_handle(name="chin")
        self.fails("the handle chin is at vertex 40 already", bpy.ops.rhytid.add_handle, name="nose")
        bpy.ops.rhytid.add_handle(name="chin", vertex=41)
        self.assertEqual(self.labels(face), ["chin", "chin_2"])
        self.fails("there is no vertex 99999", bpy.ops.rhytid.add_handle, vertex=99999)
        face.data.vertices[40].select = False
        face.data.vertices[42].select = True
        bpy.ops.object.mode_set(mode="EDIT")
        face.rhytid.handle = 0
        bpy.ops.rhytid.move_handle()
        self.assertEqual(face.rhytid.handles[0].place.vertices, (42,))
        bpy.ops.rhytid.remove_handle()
        self.assertEqual(self.labels(face), ["chin_2"])
        bpy.ops.rhytid.remove_handle(every=True)
        self.fails("no handle is chosen", bpy.ops.rhytid.remove_handle)

    def test_a_click_hits_the_nearest_vertex(self) -> None:
        face = load(demo / "neutral.obj")
        face.location, face.scale = (1, 2, 3), (0.1, 0.1, 0.1)
        bpy.context.view_layer.update()
        space, vertices = module("scene_space"), module("mesh").positions(face.data)
        front = int(vertices[:, 2].argmax())
        target, ahead = space.in_world(face, np.array([vertices[front], vertices[front] + (0, 0, 10)]))
        bpy.ops.rhytid.click_handle(origin=ahead, direction=target - ahead)
        self.assertEqual(face.rhytid.handles[0].place.vertices, (front,))
        self.fails("click on the face", bpy.ops.rhytid.click_handle, origin=ahead, direction=ahead - target)
        bpy.ops.rhytid.add_handle(name="chin", vertex=0 if front != 0 else 1)
        face.rhytid.handle = 1
        self.fails("is at vertex", bpy.ops.rhytid.click_handle, origin=ahead, direction=target - ahead, move=True)

    def test_mirror(self) -> None:
        face = load(demo / "neutral.obj")
        vertices = module("mesh").positions(face.data)
        left = next(v for v in range(len(vertices)) if vertices[v, 0] > 1 and abs(vertices[v, 1]) < 3)
        image = int(np.linalg.norm(vertices - vertices[left] * (-1, 1, 1), axis=1).argmin())
        bpy.ops.rhytid.add_handle(name="brow_L", vertex=left)
        bpy.ops.rhytid.add_handle(name="chin", vertex=image + 1)
        bpy.ops.rhytid.mirror_handles()
        self.assertEqual(self.labels(face), ["brow_L", "chin", "brow_R"])
        self.assertEqual(face.rhytid.handles[2].place.vertices, (image,))
        bpy.ops.rhytid.mirror_handles()
        self.assertEqual(len(face.rhytid.handles), 3)
        # A face that is not alike on both sides.
        face.rhytid.handles.clear()
        bpy.ops.rhytid.add_handle(name="brow_l", vertex=left)
        face.data.vertices[left].co.x += 5
        self.fails("no vertex on the other side", bpy.ops.rhytid.mirror_handles)

    def test_dots_are_where_the_handles_are(self) -> None:
        face = self.face()
        face.location = (3, 0, 0)
        bpy.context.view_layer.update()
        labels, places, chosen = module("draw").points_of(bpy.context)
        self.assertEqual((labels, chosen), (self.labels(face), 0))
        expected = [face.matrix_world @ face.data.vertices[face.rhytid.handles[5].vertices[0]].co]
        if face.rhytid.handles[5].weights[0] == 1:
            self.assertTrue(np.allclose(places[5], expected[0], atol=1e-4))
        choose(face)
        face.rhytid.handles.clear()
        self.assertIsNone(module("draw").points_of(bpy.context))
