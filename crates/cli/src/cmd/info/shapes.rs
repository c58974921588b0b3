//! `rhytid info` of blend shapes in USD.

use super::shape::{list, row};
use rhytid::formats::usd::layer::Prim;
use rhytid::formats::usd::read;
use rhytid::{Error, Result};
use serde::Serialize;
use std::path::Path;

#[derive(Serialize)]
pub(super) struct ShapesInfo {
    pub name: String,
    shapes: Vec<String>,
}

impl ShapesInfo {
    /// # Errors
    /// As reading; [`Error::Input`] if there are no blend shapes.
    pub(super) fn read(path: &Path) -> Result<Self> {
        let layer = read::open(path)?.layer;
        let mut shapes = Vec::new();
        layer.prims.iter().for_each(|prim| find(prim, &mut shapes));
        if shapes.is_empty() {
            return Err(Error::empty(format!(
                "{}: has neither an animation nor blend shapes",
                path.display()
            )));
        }
        let name = layer.prims.first().map(|prim| prim.name.clone()).unwrap_or_default();
        Ok(Self { name, shapes })
    }

    pub(super) fn rows(&self) -> Vec<[String; 2]> {
        vec![row("shapes", list(&self.shapes))]
    }
}

fn find(prim: &Prim, shapes: &mut Vec<String>) {
    if prim.type_name == "BlendShape" {
        shapes.push(prim.name.clone());
    }
    prim.children.iter().for_each(|child| find(child, shapes));
}
