"""The panels: each shows properties, operators and icons that there are. Without a window, nothing is drawn."""

from __future__ import annotations

import bpy

from support import Case, module

ICONS = set(bpy.types.UILayout.bl_rna.functions["prop"].parameters["icon"].enum_items.keys())


class Options:
    """What a button hands to its operator."""

    def __init__(self, name: str) -> None:
        group, _, operator = name.partition(".")
        self.__dict__["kind"] = getattr(getattr(bpy.ops, group), operator).get_rna_type()

    def __setattr__(self, name: str, value: object) -> None:
        assert name in self.kind.properties, f"{self.kind.identifier} has no {name}"


class Layout:
    """A layout that checks what it is given, and keeps what it shows."""

    def __init__(self, shown: list[str]) -> None:
        self.shown = shown

    def _keep(self, text: str, icon: str) -> None:
        assert icon in ICONS, icon
        self.shown.append(text)

    def row(self, **_: object) -> "Layout":
        return Layout(self.shown)

    column = row

    def label(self, text: str = "", icon: str = "NONE") -> None:
        self._keep(text, icon)

    def prop(self, data: bpy.types.bpy_struct, name: str, icon: str = "NONE", **_: object) -> None:
        assert name in data.bl_rna.properties, name
        self._keep(name, icon)

    def prop_search(self, data: bpy.types.bpy_struct, name: str, owner: object, property: str) -> None:
        assert hasattr(owner, property)
        self.prop(data, name)

    def operator(self, name: str, icon: str = "NONE", **_: object) -> Options:
        self._keep(name, icon)
        return Options(name)

    def template_list(self, kind: str, _id: str, data: object, items: str, owner: object, active: str, **_: object) -> None:
        assert hasattr(bpy.types, kind) and hasattr(data, items) and hasattr(owner, active)
        shows = getattr(bpy.types, kind).draw_item
        for item in getattr(data, items):
            shows(None, None, Layout(self.shown), data, item, 0, owner, active)


class Panels(Case):
    def shown(self, object: bpy.types.Object) -> list[str]:
        """All that the tab shows, from top to bottom."""
        shown: list[str] = []
        for panel in module("panels").CLASSES:
            if issubclass(panel, bpy.types.Panel):
                panel.contents(None, Layout(shown), object)
        return shown

    def test_every_operator_has_a_button_somewhere(self) -> None:
        face = self.playing()
        face.vertex_groups.new(name="brows")
        bpy.ops.rhytid.add_region()
        finding = face.rhytid.findings.add()
        finding.name, finding.severity, finding.vertices = "a sentence", "warning", "1 2"
        shown = set(self.shown(face))
        for source in ("EMPTIES", "CLIP", "LIVE"):
            face.rhytid.take_source = source
            shown |= set(self.shown(face))
        face.rhytid.examples_from = "FOLDER"
        shown |= set(self.shown(face))
        buttons = {name for name in shown if name.startswith("rhytid.")}
        self.assertEqual(buttons, {f"rhytid.{name}" for name in dir(bpy.ops.rhytid)})
        self.assertTrue({"a sentence", "performance.csv", "folder", "clip", "address", "brows", "1784"} <= shown)

    def test_what_keeps_the_face_from_playing_is_shown(self) -> None:
        face = self.playing()
        face.rhytid.rig_hash = ""
        bpy.context.scene.frame_set(7)
        self.assertIn(module("play").problems[face.name], self.shown(face))
