"""The extension comes and goes without a trace."""

from __future__ import annotations

import bpy

from support import ID, Case, module


class Register(Case):
    def test_unregister_leaves_nothing_behind(self) -> None:
        self.playing()
        handlers = bpy.app.handlers
        names = [name for name in dir(handlers) if isinstance(getattr(handlers, name), list)]

        def ours() -> list[str]:
            return [name for name in names for each in getattr(handlers, name) if each.__module__.startswith(ID)]

        self.assertEqual(len(ours()), 5)
        folder = module("store").folder()
        bpy.ops.preferences.addon_disable(module=ID)
        try:
            self.assertEqual(ours(), [])
            self.assertFalse(hasattr(bpy.types.Object, "rhytid"))
            self.assertEqual([name for name in dir(bpy.types) if name.startswith("RHYTID_")], [])
            self.assertEqual(dir(bpy.ops.rhytid), [])
            self.assertFalse(folder.exists())
            bpy.context.scene.frame_set(3)
        finally:
            bpy.ops.preferences.addon_enable(module=ID)
            bpy.context.preferences.addons[ID].preferences.device = "cpu:0"
        self.assertEqual(len(ours()), 5)

    def test_every_operator_says_what_it_does(self) -> None:
        names = dir(bpy.ops.rhytid)
        self.assertGreater(len(names), 20)
        for name in names:
            kind = getattr(bpy.ops.rhytid, name).get_rna_type()
            self.assertTrue(kind.description and kind.name, name)
