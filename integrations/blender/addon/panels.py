"""The tab Rhytid of the sidebar: a panel for each step, in the order of work."""

from __future__ import annotations

import bpy
from bpy.props import StringProperty

from . import mesh, play

#: Icons of the doctor's findings.
ICONS = {"error": "CANCEL", "warning": "ERROR", "note": "INFO"}


class Preferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    device: StringProperty(
        name="Device", default="auto", description="Where faces are computed: auto, cpu:0, vulkan:0, …"
    )

    def draw(self, _context: bpy.types.Context) -> None:
        self.layout.prop(self, "device")


class Handles(bpy.types.UIList):
    bl_idname = "RHYTID_UL_handles"

    def draw_item(self, _context, layout, _data, item, _icon, _active_data, _active_property, _index=0, _flag=0):  # type: ignore[no-untyped-def]
        layout.prop(item, "name", text="", emboss=False, icon="DOT")
        layout.label(text=", ".join(map(str, item.place.vertices)))


class Panel:
    """What all panels share."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Rhytid"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.object is not None

    def draw(self, context: bpy.types.Context) -> None:
        try:
            object = mesh.face_of(context)
        except mesh.Problem as problem:
            self.layout.label(text=str(problem).split(";")[0])
            return
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        self.contents(self.layout, object)

    def contents(self, layout: bpy.types.UILayout, object: bpy.types.Object) -> None:
        raise NotImplementedError


class FacePanel(Panel, bpy.types.Panel):
    bl_idname = "RHYTID_PT_face"
    bl_label = "Face"

    def contents(self, layout: bpy.types.UILayout, object: bpy.types.Object) -> None:
        settings = object.rhytid
        layout.label(text=f"Neutral: {object.name}", icon="MESH_DATA")
        layout.prop(settings, "unit")
        layout.prop(settings, "examples_from")
        if settings.examples_from == "FOLDER":
            layout.prop(settings, "folder")
        elif settings.examples_from == "OBJECTS":
            for index, item in enumerate(settings.examples):
                row = layout.row(align=True)
                row.prop(item, "object", text="")
                row.operator("rhytid.remove_example", text="", icon="X").index = index
            layout.operator("rhytid.add_examples", icon="ADD")
        layout.operator("rhytid.doctor", icon="VIEWZOOM")
        for index, finding in enumerate(settings.findings):
            row = layout.row(align=True)
            row.label(text=finding.name, icon=ICONS.get(finding.severity, "INFO"))
            if finding.vertices:
                row.operator("rhytid.select_finding", text="", icon="RESTRICT_SELECT_OFF").index = index
        layout.operator("rhytid.save_project", icon="EXPORT")


class HandlesPanel(Panel, bpy.types.Panel):
    bl_idname = "RHYTID_PT_handles"
    bl_label = "Handles"

    def contents(self, layout: bpy.types.UILayout, object: bpy.types.Object) -> None:
        settings = object.rhytid
        row = layout.row(align=True)
        row.prop(settings, "count")
        row.operator("rhytid.handles_by_count", text="", icon="PLAY")
        layout.prop(settings, "take_path")
        layout.operator("rhytid.handles_from_take", icon="CURSOR")
        layout.template_list("RHYTID_UL_handles", "", settings, "handles", settings, "handle", rows=4)
        row = layout.row(align=True)
        row.operator("rhytid.click_handle", text="Click", icon="RESTRICT_SELECT_OFF").move = False
        row.operator("rhytid.click_handle", text="Move", icon="EMPTY_ARROWS").move = True
        row = layout.row(align=True)
        row.operator("rhytid.add_handle", text="At Vertex", icon="ADD")
        row.operator("rhytid.move_handle", text="To Vertex", icon="VERTEXSEL")
        row = layout.row(align=True)
        row.operator("rhytid.mirror_handles", icon="MOD_MIRROR")
        row.operator("rhytid.remove_handle", icon="REMOVE").every = False
        layout.prop_search(settings, "pins", object, "vertex_groups")
        layout.prop(settings, "store")
        layout.operator("rhytid.solve", icon="SHADERFX")


class TakePanel(Panel, bpy.types.Panel):
    bl_idname = "RHYTID_PT_take"
    bl_label = "Take"

    def contents(self, layout: bpy.types.UILayout, object: bpy.types.Object) -> None:
        settings = object.rhytid
        layout.prop(settings, "take_source")
        if settings.take_source == "LIVE":
            layout.prop(settings, "address")
            layout.operator("rhytid.live", icon="REC")
        else:
            layout.prop(settings, "head_moves")
        if settings.take_source == "FILE":
            layout.prop(settings, "take_path")
            layout.operator("rhytid.open_take", icon="FILE_FOLDER")
        elif settings.take_source == "EMPTIES":
            layout.operator("rhytid.take_objects", icon="EMPTY_AXIS")
        elif settings.take_source == "CLIP":
            layout.prop(settings, "clip")
            layout.operator("rhytid.take_clip", icon="TRACKER")
        if settings.take_name:
            layout.label(text=settings.take_name, icon="CHECKMARK")


class PlayPanel(Panel, bpy.types.Panel):
    bl_idname = "RHYTID_PT_play"
    bl_label = "Play"

    def contents(self, layout: bpy.types.UILayout, object: bpy.types.Object) -> None:
        settings = object.rhytid
        layout.operator("rhytid.play", icon="PLAY", depress=settings.playing)
        layout.prop(settings, "source", expand=True)
        layout.prop(settings, "start")
        row = layout.row()
        row.use_property_decorate = True
        row.prop(settings, "detail", slider=True)
        column = layout.column(heading="Attributes")
        for name in ("strain", "wrinkles", "sigma"):
            column.prop(settings, name)
        for index, region in enumerate(settings.regions):
            row = layout.row(align=True)
            row.label(text=region.name, icon="GROUP_VERTEX")
            row.prop(region, "detail", text="")
            row.prop(region, "motion", text="")
            row.operator("rhytid.remove_region", text="", icon="X").index = index
        layout.operator("rhytid.add_region", icon="ADD")
        layout.operator("rhytid.update", icon="FILE_REFRESH")
        if object.name in play.problems:
            layout.label(text=play.problems[object.name], icon="ERROR")


class BakePanel(Panel, bpy.types.Panel):
    bl_idname = "RHYTID_PT_bake"
    bl_label = "Bake"

    def contents(self, layout: bpy.types.UILayout, object: bpy.types.Object) -> None:
        settings = object.rhytid
        layout.prop(settings, "shapes")
        layout.operator("rhytid.bake_shapes", icon="SHAPEKEY_DATA")
        layout.prop(settings, "cache_path")
        layout.operator("rhytid.bake_cache", icon="FILE_CACHE")
        row = layout.row(align=True)
        row.operator("rhytid.bake_handles", text="To Empties", icon="EMPTY_AXIS").kind = "EMPTIES"
        row.operator("rhytid.bake_handles", text="To Bones", icon="BONE_DATA").kind = "BONES"


CLASSES = (Preferences, Handles, FacePanel, HandlesPanel, TakePanel, PlayPanel, BakePanel)


def register() -> None:
    for each in CLASSES:
        bpy.utils.register_class(each)


def unregister() -> None:
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
