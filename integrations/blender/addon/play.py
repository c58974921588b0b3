"""The tab Play: faces follow the scene's frame, or the objects of their handles."""

from __future__ import annotations

import bpy
from bpy.app.handlers import persistent

from . import mesh, player, store, timing
from .problem import EXPECTED, Problem, reported, sentence

#: What plays each face, by the object's name. It is made again if the settings ask for something else.
_players: dict[str, player.Player] = {}
_followers: dict[str, player.Follower] = {}
#: What keeps a face from playing, by the object's name. The panel shows it.
problems: dict[str, str] = {}
#: Faces that do not follow the frame at the moment, by the object's name: `live` shows them, or they are not needed.
paused: set[str] = set()


def faces_of(scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """The faces of a scene that play, one for each mesh. An object that shares its mesh shows what the first does."""
    found: dict[str, bpy.types.Object] = {}
    for object in scene.objects:
        if object.type == "MESH" and object.rhytid.playing:
            found.setdefault(object.data.name, object)
    return list(found.values())


def channels_of(object: bpy.types.Object, scene: bpy.types.Scene) -> player.Channels:
    """What a face shows in the scene's frame."""
    settings = object.rhytid
    if settings.source == "HANDLES":
        wish = (settings.rig_hash, player.device())
        follower = _followers.get(object.name)
        if follower is None or follower.wish != wish:
            follower = _followers[object.name] = player.Follower.of(object, wish)
        return follower.at(player.control_positions(object, store.rig(object)), settings.detail)
    plays = player_of(object, scene)
    place = timing.place(scene.frame_current_final, settings.start, len(plays))
    return plays.at(place, settings.detail)


def player_of(object: bpy.types.Object, scene: bpy.types.Scene) -> player.Player:
    """What plays the take of a face, by its settings at this moment."""
    wish = player.wish_of(object, scene)
    plays = _players.get(object.name)
    if plays is None or plays.wish != wish:
        plays = _players[object.name] = player.Player.of(object, wish)
    return plays


def show(object: bpy.types.Object, channels: player.Channels) -> None:
    """Puts the channels of a frame into the mesh."""
    mesh.check_count(object, len(channels["positions"]))
    mesh.show(object, channels["positions"])
    for name, values in channels.items():
        if name == "positions":
            continue
        if values.ndim == 2 and values.shape[1] != 3:
            for column in range(values.shape[1]):
                mesh.write_attribute(object.data, f"{name}{column + 1}", values[:, column])
        else:
            mesh.write_attribute(object.data, name, values)


def show_one(object: bpy.types.Object, scene: bpy.types.Scene) -> None:
    """Shows a face in the scene's frame, or keeps its problem for the panel."""
    if object.data.is_editmode or object.name in paused:
        # While it is edited, the mesh belongs to the user.
        return
    try:
        if not (object.is_editable and object.data.is_editable):
            raise Problem(f"the face {object.name} is linked from another file; make it local to play it")
        show(object, channels_of(object, scene))
    except EXPECTED as error:
        problems[object.name] = sentence(error)
    else:
        problems.pop(object.name, None)


def show_all(scene: bpy.types.Scene) -> None:
    """Shows all faces of the scene in its frame."""
    faces = faces_of(scene)
    for object in faces:
        show_one(object, scene)
    # Where an object went or was called otherwise, its player goes too.
    names = {object.name for object in faces}
    for kept in (_players, _followers, problems):
        for name in [name for name in kept if name not in names and name not in bpy.data.objects]:
            del kept[name]
    limit(list(_players.values()))


def limit(players: list[player.Player]) -> None:
    """Drops frames until all players together are within the bound of memory."""
    while sum(plays.bytes for plays in players) > player.MOST_BYTES:
        largest = max(players, key=lambda plays: plays.bytes)
        if len(largest.kept) <= 2:
            break
        largest.forget_one()


def refresh(scene: bpy.types.Scene) -> None:
    """Shows all faces anew after a setting changed, and the neutral of those that play no more."""
    for object in scene.objects:
        if object.type == "MESH" and object.data.is_editable:
            key = mesh.play_key(object)
            if key is not None:
                others = (other for other in scene.objects if other.type == "MESH" and other.data == object.data)
                key.mute = not any(other.rhytid.playing for other in others)
    show_all(scene)


def forget() -> None:
    """Drops all that is in memory alone."""
    for kept in (_players, _followers, problems, paused):
        kept.clear()


@persistent
def frame_changed(scene: bpy.types.Scene, _depsgraph: bpy.types.Depsgraph | None = None) -> None:
    show_all(scene)


@persistent
def moved(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    """Follows handles that are dragged."""
    followers = [object for object in faces_of(scene) if object.rhytid.source == "HANDLES"]
    if not followers:
        return
    armatures = {object.rhytid.armature.name for object in followers if object.rhytid.armature is not None}
    changed = [update.id for update in depsgraph.updates if isinstance(update.id, bpy.types.Object)]
    if any(each.rhytid_handle or each.name in armatures for each in changed):
        for object in followers:
            show_one(object, scene)


@persistent
def found_again(*_: object) -> None:
    """After a file is opened, and after an undo: all is found again from the properties."""
    forget()
    if bpy.context.scene is not None:
        show_all(bpy.context.scene)


class Update(bpy.types.Operator):
    """Read the painted regions again, and show the face anew"""

    bl_idname = "rhytid.update"
    bl_label = "Update"
    bl_options = {"REGISTER"}

    @reported
    def execute(self, context: bpy.types.Context) -> set[str]:
        object = mesh.face_of(context)
        forget()
        refresh(context.scene)
        if object.name in problems:
            raise Problem(problems[object.name])
        return {"FINISHED"}


class Follow(bpy.types.Operator):
    """Let the face follow the scene's frame, or show the neutral"""

    bl_idname = "rhytid.play"
    bl_label = "Follow the Frame"
    bl_options = {"REGISTER", "UNDO"}

    @reported
    def execute(self, context: bpy.types.Context) -> set[str]:
        object = mesh.face_of(context)
        object.rhytid.playing = not object.rhytid.playing
        if object.rhytid.playing and object.name in problems:
            text = problems.pop(object.name)
            object.rhytid.playing = False
            raise Problem(text)
        others = mesh.other_keys(object) if object.rhytid.playing else []
        if others:
            self.report({"WARNING"}, f"The shape keys {', '.join(others)} add to the face; set their values to 0")
        return {"FINISHED"}


CLASSES = (Update, Follow)
HANDLERS = (
    ("frame_change_post", frame_changed),
    ("depsgraph_update_post", moved),
    ("load_post", found_again),
    ("undo_post", found_again),
    ("redo_post", found_again),
)


def register() -> None:
    for each in CLASSES:
        bpy.utils.register_class(each)
    for name, handler in HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def unregister() -> None:
    for name, handler in HANDLERS:
        handlers = getattr(bpy.app.handlers, name)
        if handler in handlers:
            handlers.remove(handler)
    forget()
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
