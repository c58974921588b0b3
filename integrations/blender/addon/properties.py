"""What is kept in the .blend file: the settings of a face, its handles, and where its rig and its take are."""

from __future__ import annotations

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    IntVectorProperty,
    PointerProperty,
    StringProperty,
)

from . import project

#: What lets a path begin with `//`. Before Blender 4.5, every path may.
RELATIVE = {"ANIMATABLE", "PATH_SUPPORTS_BLEND_RELATIVE"} if bpy.app.version >= (4, 5) else {"ANIMATABLE"}


def changed(_owner: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    """Shows the face anew after a setting of the play changed."""
    from . import play

    if context.scene is not None:
        play.refresh(context.scene)


def is_mesh(_owner: bpy.types.PropertyGroup, candidate: bpy.types.Object) -> bool:
    return candidate.type == "MESH"


class ExampleItem(bpy.types.PropertyGroup):
    """An object that is an example."""

    object: PointerProperty(type=bpy.types.Object, poll=is_mesh, name="Object")


class HandleItem(bpy.types.PropertyGroup):
    """A marker's place on the mesh. Its name is the marker's label."""

    vertices: IntVectorProperty(size=3, name="Vertices", description="The vertices of the handle, from 0")
    weights: FloatVectorProperty(size=3, default=(1, 0, 0), precision=6, name="Weights")

    @property
    def place(self) -> project.Handle:
        """The handle as the library has it."""
        if self.weights[1] == 0 and self.weights[2] == 0:
            return project.Handle(self.name, (self.vertices[0],))
        # Weights are float32 here, and their sum is 1 within 1e-7.
        return project.Handle(self.name, tuple(self.vertices), tuple(self.weights))

    def put(self, handle: project.Handle) -> None:
        """Sets the handle's label and place."""
        rest = 3 - len(handle.vertices)
        self.name = handle.label
        self.vertices = (*handle.vertices, *[handle.vertices[0]] * rest)
        self.weights = (*handle.weights, *[0.0] * rest)


class FindingItem(bpy.types.PropertyGroup):
    """A finding of the doctor. Its name is its sentence."""

    severity: StringProperty(name="Severity")
    code: StringProperty(name="Code")
    vertices: StringProperty(name="Vertices", description="Numbers of vertices, separated by blanks")


class RegionItem(bpy.types.PropertyGroup):
    """A painted region: a vertex group by its name."""

    detail: FloatProperty(
        name="Detail", default=1, min=0, max=2, update=changed, description="Multiplies the wrinkles of the region"
    )
    motion: FloatProperty(
        name="Motion", default=1, min=0, max=10, update=changed, description="Multiplies how far its handles move"
    )


class FaceSettings(bpy.types.PropertyGroup):
    """The settings of a face, at the object of its neutral."""

    # Face.
    unit: EnumProperty(
        name="Unit",
        description="The length of one unit of the mesh's own coordinates",
        items=(
            ("SCENE", "Scene", "What the scene's unit scale and the object's scale say"),
            ("mm", "Millimetres", "The mesh is in millimetres"),
            ("cm", "Centimetres", "The mesh is in centimetres"),
            ("m", "Metres", "The mesh is in metres"),
            ("in", "Inches", "The mesh is in inches"),
        ),
    )
    examples_from: EnumProperty(
        name="Examples",
        items=(
            ("OBJECTS", "Objects", "Objects with the neutral's vertices in the same order"),
            ("SHAPE_KEYS", "Shape Keys", "The shape keys of the neutral"),
            ("FOLDER", "Folder", "Meshes in a folder, in the space of the neutral's own coordinates"),
        ),
    )
    examples: CollectionProperty(type=ExampleItem)
    folder: StringProperty(name="Folder", subtype="DIR_PATH", options=RELATIVE)
    findings: CollectionProperty(type=FindingItem)
    finding: IntProperty()
    # Handles.
    handles: CollectionProperty(type=HandleItem)
    handle: IntProperty()
    count: IntProperty(name="Count", default=90, min=4, max=1000, description="The number of handles")
    pins: StringProperty(name="Pins", description="A vertex group that stays still: weights from 0.5 on")
    regions: CollectionProperty(type=RegionItem)
    region: IntProperty()
    # The rig: a datablock that is packed in the file, or a file beside it.
    store: EnumProperty(
        name="Keep the Rig",
        items=(
            ("PACKED", "In the .blend", "The rig is a part of the .blend file"),
            ("BESIDE", "Beside It", "The rig is a file in the folder of the .blend file"),
        ),
    )
    data: PointerProperty(type=bpy.types.Text)
    rig_path: StringProperty(name="Rig File", subtype="FILE_PATH", options=RELATIVE)
    rig_hash: StringProperty()
    # Take.
    take_source: EnumProperty(
        name="From",
        items=(
            ("FILE", "File", "A clean take, or what a capture system wrote"),
            ("EMPTIES", "Empties", "The selected empties, called as the handles"),
            ("CLIP", "Clip", "The tracks of a movie clip, called as the handles"),
            ("LIVE", "Live", "Markers that come over the network"),
        ),
    )
    take_path: StringProperty(name="Take", subtype="FILE_PATH", options=RELATIVE)
    clip: PointerProperty(type=bpy.types.MovieClip, name="Clip")
    head_moves: BoolProperty(name="Head Moves", description="Take the head's motion out of the markers")
    address: StringProperty(name="Address", default="127.0.0.1:9000", description="Where to listen for markers")
    take_hash: StringProperty()
    take_name: StringProperty()
    # Play.
    playing: BoolProperty(name="Follow the Frame", update=changed, description="The face follows the scene's frame")
    source: EnumProperty(
        name="Drive By",
        update=changed,
        items=(
            ("TAKE", "Take", "The face follows the take"),
            ("HANDLES", "Handles", "The face follows the objects of its handles"),
        ),
    )
    start: FloatProperty(
        name="Start", default=0, update=changed, description="The frame of the scene at which the take begins"
    )
    detail: FloatProperty(
        name="Detail",
        default=1,
        min=0,
        max=2,
        options={"ANIMATABLE"},
        update=changed,
        description="Multiplies the wrinkles",
    )
    strain: BoolProperty(name="Strain", update=changed, description="Write the strain as attributes")
    wrinkles: BoolProperty(name="Wrinkles", update=changed, description="Write the wrinkle of each example")
    sigma: BoolProperty(name="Sigma", update=changed, description="Write the standard deviation")
    controls: PointerProperty(type=bpy.types.Collection)
    armature: PointerProperty(type=bpy.types.Object)
    # Bake.
    shapes: IntProperty(name="Shapes", default=20, min=1, max=500, description="The number of shape keys")
    cache_path: StringProperty(name="Cache", default="//face.usdc", subtype="FILE_PATH", options=RELATIVE)


CLASSES = (ExampleItem, HandleItem, FindingItem, RegionItem, FaceSettings)


def register() -> None:
    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Object.rhytid = PointerProperty(type=FaceSettings, name="Rhytid")
    bpy.types.Object.rhytid_handle = StringProperty(name="Handle", description="The label of the handle that it moves")


def unregister() -> None:
    del bpy.types.Object.rhytid
    del bpy.types.Object.rhytid_handle
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
