//! A rig that is evaluated on the processor and drawn.
use crate::Drawing;
use rhytid_backend_cpu::{Cpu, CpuSession};
use rhytid_core::{
    Animator, BasisStorage, HandleFrames, Look, Materials, Result, Rig, Stage, Texture, TextureFormat,
    Transparency, UploadOptions, rig_file,
};
use serde_json::{Value, json};

/// A rig, how it is drawn, and its last frame on the processor.
#[derive(Debug)]
pub struct Face {
    rig: Rig,
    drawing: Drawing,
    basis: BasisStorage,
    /// Made with the first frame that the processor evaluates.
    processor: Option<Animator<CpuSession>>,
    positions: Vec<f32>,
    normals: Vec<f32>,
}

impl Face {
    /// Reads the rig file `name`, plain or packed.
    ///
    /// # Errors
    /// As [`rig_file::decode`] and [`UploadOptions::check`].
    pub fn open(bytes: &[u8], name: &str, basis: BasisStorage) -> Result<Self> {
        let rig = rig_file::decode(bytes, name)?;
        UploadOptions { max_frames: 1, basis }.check(&rig)?;
        let drawing = Drawing::new(rig.surface())?;
        Ok(Self { rig, drawing, basis, processor: None, positions: Vec::new(), normals: Vec::new() })
    }

    /// The rig.
    pub fn rig(&self) -> &Rig {
        &self.rig
    }

    /// How it is drawn.
    pub fn drawing(&self) -> &Drawing {
        &self.drawing
    }

    /// How devices keep its basis.
    pub fn basis(&self) -> BasisStorage {
        self.basis
    }

    /// (V + C)×3 positions at rest, in mesh units: the vertices, and their copies behind them.
    pub fn rest(&self) -> Vec<f32> {
        let mut rest = self.rig.surface().rest.as_flattened().to_vec();
        self.drawing.add_copies(&mut rest);
        rest
    }

    /// Checks H×3 handle positions.
    ///
    /// # Errors
    /// As [`HandleFrames::checked`].
    pub fn check(&self, handles: &[f32]) -> Result<()> {
        HandleFrames::checked(handles, self.rig.handles().len(), 1).map(|_| ())
    }

    /// Evaluates a frame of H×3 handle positions on the processor.
    ///
    /// # Errors
    /// As [`Animator::new`] and [`Animator::evaluate`].
    pub fn evaluate(&mut self, handles: &[f32]) -> Result<()> {
        let options = UploadOptions { max_frames: 1, basis: self.basis };
        let animator = match &mut self.processor {
            Some(animator) => animator,
            none => none.insert(Animator::new(&Cpu, &self.rig, options)?),
        };
        animator.evaluate(handles)?;
        for (stage, numbers) in [(Stage::Positions, &mut self.positions), (Stage::Normals, &mut self.normals)]
        {
            animator.read(stage, numbers)?;
            self.drawing.add_copies(numbers);
        }
        Ok(())
    }

    /// (V + C)×3 positions of the last frame on the processor, in mesh units. Empty before the first.
    pub fn positions(&self) -> &[f32] {
        &self.positions
    }

    /// (V + C)×3 normals of the last frame on the processor. Empty before the first.
    pub fn normals(&self) -> &[f32] {
        &self.normals
    }

    /// A stage of the last frame on the processor, without copies of vertices.
    ///
    /// # Errors
    /// As [`Animator::read`].
    pub fn read(&mut self, stage: Stage) -> Result<Vec<f32>> {
        let mut numbers = Vec::new();
        match &mut self.processor {
            Some(animator) => animator.read(stage, &mut numbers)?,
            None => {
                let rest = self.rig.handles().rest.as_flattened().to_vec();
                self.evaluate(&rest)?;
                return self.read(stage);
            }
        }
        Ok(numbers)
    }

    /// The face as JSON.
    ///
    /// - `name`, `vertices`, `metresPerUnit` and `upAxis`.
    /// - `handles`: `name` and `rest` of each.
    /// - `groups`: `first`, `count` and `material` of triangles.
    /// - `materials`: those of the rig, and behind them the one of faces without a material.
    /// - `textures`: the media type of each.
    pub fn facts(&self) -> Value {
        let (surface, handles) = (self.rig.surface(), self.rig.handles());
        let handle =
            |(name, rest): (&String, &[f32; 3])| json!({ "name": name, "rest": rest.map(f64::from) });
        let mut materials = Vec::new();
        let mut textures = Vec::new();
        if let Some(of_rig) = &surface.materials {
            materials.extend(of_rig.list.iter().map(|material| look_facts(&material.name, &material.look())));
            let mime = |texture: &Texture| texture.format().map(TextureFormat::mime);
            textures.extend(of_rig.textures.iter().map(mime));
        }
        materials.push(look_facts("", &Materials::look_without()));
        json!({
            "name": surface.name,
            "vertices": self.rig.vertices(),
            "metresPerUnit": surface.metres_per_unit,
            "upAxis": surface.up_axis,
            "handles": handles.labels.iter().zip(&handles.rest).map(handle).collect::<Vec<_>>(),
            "groups": self.drawing.groups,
            "materials": materials,
            "textures": textures,
        })
    }
}

fn look_facts(name: &str, look: &Look) -> Value {
    let (transparency, cutoff) = match look.transparency {
        Transparency::Opaque => ("opaque", None),
        Transparency::Mask(cutoff) => ("mask", Some(cutoff)),
        Transparency::Blend => ("blend", None),
    };
    json!({
        "name": name,
        "color": look.base_color,
        "texture": look.texture,
        "opacity": look.opacity,
        "transparency": transparency,
        "cutoff": cutoff,
        "roughness": look.roughness,
        "metalness": look.metallic,
    })
}
