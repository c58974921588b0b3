//! The nodes of a document and where they are.

use ::gltf::json::scene::Node as Described;
use ::gltf::json::{Index, Root};
use glam::DMat4;
use rhytid_core::{Error, Result};
use rhytid_gltf::local_transform;

/// A node of the scene.
pub(super) struct Placed<'a> {
    pub index: usize,
    pub node: &'a Described,
    /// To scene space.
    pub transform: DMat4,
}

/// The nodes of a document.
pub(super) struct Nodes<'a> {
    /// Those of the default scene (else of the first), parents first.
    pub placed: Vec<Placed<'a>>,
    /// The transform of every node to the space of its scene or, outside of the scene, of its root. `None`
    /// for nodes that are their own ancestors.
    transforms: Vec<Option<DMat4>>,
}

impl<'a> Nodes<'a> {
    pub(super) fn read(root: &'a Root, name: &str) -> Result<Self> {
        let scene = root.scene.map_or(0, |scene| scene.value());
        let Some(scene) = root.scenes.get(scene) else {
            return Err(Error::malformed(format!(
                "{name}: has {} scenes, expected a default one with number {scene}; export the mesh again",
                root.scenes.len()
            )));
        };
        let mut nodes = Self { placed: Vec::new(), transforms: vec![None; root.nodes.len()] };
        nodes.walk(root, &scene.nodes, name)?;
        nodes.place_others(root);
        Ok(nodes)
    }

    /// The transform of a node; `None` if it does not exist or is its own ancestor.
    pub(super) fn transform(&self, index: usize) -> Option<DMat4> {
        self.transforms.get(index).copied().flatten()
    }

    /// Places the trees below the scene's nodes.
    fn walk(&mut self, root: &'a Root, top: &[Index<Described>], name: &str) -> Result<()> {
        let fail = |what: String| Err(Error::malformed(format!("{name}: {what}")));
        // A stack, not recursion: a chain of nodes can be longer than the call stack.
        let mut next: Vec<_> = top.iter().rev().map(|node| (node.value(), DMat4::IDENTITY)).collect();
        while let Some((index, parent)) = next.pop() {
            let (Some(node), Some(place)) = (root.nodes.get(index), self.transforms.get_mut(index)) else {
                return fail(format!(
                    "node {index} does not exist, expected one of the {}",
                    root.nodes.len()
                ));
            };
            if place.is_some() {
                return fail(format!("node {index} is placed twice, expected a tree of nodes"));
            }
            let transform = parent * local_transform(node);
            *place = Some(transform);
            next.extend(node.children.iter().flatten().rev().map(|child| (child.value(), transform)));
            self.placed.push(Placed { index, node, transform });
        }
        Ok(())
    }

    /// Places the nodes outside of the scene: joints may be there.
    fn place_others(&mut self, root: &Root) {
        let mut has_parent = vec![false; root.nodes.len()];
        for child in root.nodes.iter().flat_map(|node| node.children.iter().flatten()) {
            if let Some(has_parent) = has_parent.get_mut(child.value()) {
                *has_parent = true;
            }
        }
        let tops = (0..root.nodes.len()).filter(|&index| !has_parent[index]);
        let mut next: Vec<_> = tops.map(|index| (index, DMat4::IDENTITY)).collect();
        while let Some((index, parent)) = next.pop() {
            let Some(place @ None) = self.transforms.get_mut(index) else { continue };
            let transform = parent * local_transform(&root.nodes[index]);
            *place = Some(transform);
            let children = root.nodes[index].children.iter().flatten();
            next.extend(children.map(|child| (child.value(), transform)));
        }
    }
}
