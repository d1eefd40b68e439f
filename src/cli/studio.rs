//! A file set up for its pictures: opened once, looked at from one moment to the next.

use std::collections::HashSet;
use std::time::Instant;

use super::moment::{self, Playing};
use super::render::RenderArgs;
use super::sequence::Shot;
use super::value::Background;
use super::view::{self, Stage};
use crate::error::Error;
use crate::gltf::{self, Asset, LoadOptions, Loaded, Treatment};
use crate::pack::outline::Outline;
use crate::pack::{self, Packed, Packer, View};
use crate::report::{self, Times};

pub struct Studio<'a> {
    args: &'a RenderArgs,
    asset: Asset,
    pub playing: Playing,
    packer: Packer,
    /// What all of a sequence's cameras are placed by, once it is known.
    stage: Option<Stage>,
    /// A sequence says each thing once.
    said: HashSet<String>,
}

/// Everything about a picture that is settled before its first ray.
pub struct Job {
    pub shot: Shot,
    pub loaded: Loaded,
    pub camera_name: String,
    pub packed: Packed,
}

/// So many moments of what plays are looked at to place a sequence's camera.
const LOOKS: u32 = 32;

impl<'a> Studio<'a> {
    pub fn open(args: &'a RenderArgs, times: &mut Times) -> Result<Self, Error> {
        let start = Instant::now();
        let mut asset = Asset::open(
            &args.scene,
            &LoadOptions {
                allow_paths: args.allow_path.clone(),
                max_memory: args.max_memory,
                environment: args.env.clone(),
            },
        )?;
        moment::choose_variant(&mut asset, args.variant.as_deref())?;
        let playing = Playing::choose(&asset, args)?;
        times.load = report::milliseconds(start.elapsed());
        Ok(Self {
            args,
            asset,
            playing,
            packer: Packer::default(),
            stage: None,
            said: HashSet::new(),
        })
    }

    /// Loads and packs a picture's moment; see `Packer::pack_and_tell`.
    pub fn prepare(
        &mut self,
        shot: Shot,
        times: &mut Times,
        tell: Option<&mut dyn FnMut(Outline)>,
    ) -> Result<Job, Error> {
        let args = self.args;
        let start = Instant::now();
        let loaded = self.load(shot.seconds)?;
        times.load += report::milliseconds(start.elapsed());
        times.images = report::milliseconds(loaded.image_time);
        self.say_notes(&loaded);

        let start = Instant::now();
        let scene = &loaded.scene;
        if view::is_staged(scene, args) && self.stage.is_none() {
            self.stage = Some(self.survey(&loaded, &shot)?);
        }
        let (camera, camera_name) = view::choose(scene, args, self.stage.as_ref(), shot.turn)?;
        let mut packed = self.packer.pack_and_tell(
            scene,
            &View {
                camera,
                film_size: args.size,
                seed: shot.seed,
                max_depth: args.max_depth,
                background: match args.background {
                    Background::Environment => pack::Background::Environment,
                    Background::Color(color) => pack::Background::Color(color),
                    Background::Transparent => pack::Background::Transparent,
                },
                clamp: args.clamp.map(|limit| limit as f32),
            },
            tell,
        )?;
        view::focus(scene, args, &mut packed)?;
        times.pack = report::milliseconds(start.elapsed());
        times.geometry = report::milliseconds(self.packer.geometry_time);
        Ok(Job {
            shot,
            loaded,
            camera_name,
            packed,
        })
    }

    fn load(&mut self, seconds: f64) -> Result<Loaded, Error> {
        let args = self.args;
        let mut loaded = self.asset.scene(&self.playing.moment(seconds))?;
        let extensions = loaded.extensions.iter();
        let ignored: Vec<_> = extensions.filter(|e| e.is_missed()).cloned().collect();
        if args.strict && !ignored.is_empty() {
            return Err(Error::Strict {
                scene: args.scene.clone(),
                ignored,
            });
        }
        if let Some(environment) = &mut loaded.scene.environment {
            environment.strength *= args.env_strength as f32;
            environment.rotation += args.env_rotation.to_radians() as f32;
        }
        loaded.notes.extend(self.playing.note.clone());
        Ok(loaded)
    }

    /// Where the scene is: in this picture; for a sequence, at all times that anything moves, so that
    /// the camera stands still and a frame is the same whichever others are made beside it.
    fn survey(&mut self, loaded: &Loaded, shot: &Shot) -> Result<Stage, Error> {
        if shot.frame.is_none() || self.playing.is_still() {
            let bounds = gltf::bounds(&loaded.scene);
            return Ok(Stage::new(&loaded.scene, bounds, self.args));
        }
        let [first, last] = self.playing.span;
        let scene = self.load(first)?.scene;
        let mut bounds = gltf::bounds(&scene);
        for look in 1..=LOOKS {
            let part = f64::from(look) / f64::from(LOOKS);
            let later = self.load(first + part * (last - first))?.scene;
            bounds = view::around(bounds, gltf::bounds(&later));
        }
        Ok(Stage::new(&scene, bounds, self.args))
    }

    /// What the pictures will not show.
    fn say_notes(&mut self, loaded: &Loaded) {
        let extensions = loaded.extensions.iter();
        let left_out = extensions
            .filter(|extension| extension.treatment != Treatment::Supported)
            .map(|extension| format!("{}: {}", extension.name, extension.detail));
        for note in left_out.chain(loaded.notes.iter().cloned()) {
            if !self.args.quiet && !self.said.contains(&note) {
                super::say(&format!("note: {note}"));
                self.said.insert(note);
            }
        }
    }
}
