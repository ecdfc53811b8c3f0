//! The flags of the scene: geometry, camera and integral.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use glam::{DQuat, DVec3};
use sphvar_integrands::{EnvironmentMap, Integrand, Interpolation, PictureParameters, UpAxis};
use sphvar_scene::{
    Camera, CornellBox, CropWindow, Density, Integral, LightMap, Mesh, Quad, Scene, View,
};

use super::numbers::{Numbers, Size};
use super::reference_file::fingerprint;
use crate::counts::parse_number;
use crate::error::CliError;
use crate::files::read_whole;
use crate::integrands::environment::{Environment, PictureSource, to_map};
use crate::session::Session;
use crate::spec::{Spec, argument, unknown_name};

/// The names of integrals and their parameters, for help texts.
const INTEGRALS: &str = "ao[:weight=cosine] | irradiance:env=FILE[,albedo=1], and the parameters of the integrand \
     env: (channel, layer, projection, up, mirror, rotate; up is --up unless given) | light[:albedo=1]";

/// The field of view of a mesh, degrees.
const DEFAULT_FOV: f64 = 40.0;

/// The default number of pixels on each side of a picture, of a picture of a study, and of a panel
/// of a sheet.
pub(super) const PICTURE_SIZE: usize = 512;
pub(super) const STUDY_SIZE: usize = 128;
pub(super) const PANEL_SIZE: usize = 256;

/// Flags about the scene.
#[derive(Debug, Args)]
pub(crate) struct StageArgs {
    /// Scene: cornell, or a mesh in Wavefront form (.obj, .obj.gz)
    pub(super) scene: String,
    #[arg(long, value_parser = argument(), default_value = "ao", help = format!("Integral over the hemisphere of each shading point: {INTEGRALS}"))]
    integral: String,
    /// Ignore occluders farther away than this, for ao [default: none are ignored]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true, value_parser = parse_number)]
    max_distance: Option<f64>,
    #[arg(long, value_name = "W[xH]", help = format!(
        "Width and height in pixels, or the side of a square [default: {}; of a study {}; of a panel {}]",
        PICTURE_SIZE, STUDY_SIZE, PANEL_SIZE
    ))]
    size: Option<Size>,
    /// Render this part of the picture only
    #[arg(long, value_name = "X,Y,W,H")]
    crop: Option<Numbers<4, usize>>,
    /// Primary rays of a pixel, K by K, each with its own directions, averaged over those that hit surfaces (a box filter)
    #[arg(long, value_name = "K", default_value_t = 1)]
    pixel_rays: usize,
    /// Position of the camera [default: that of the Cornell box; for a mesh such that it fills the picture]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    eye: Option<Numbers<3, f64>>,
    /// Point in the middle of the picture [default: the middle of the scene]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    look_at: Option<Numbers<3, f64>>,
    /// Upward direction, of the camera and of the environment map [default: 0,1,0]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    up: Option<Numbers<3, f64>>,
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, value_parser = parse_number, help = format!(
        "Vertical field of view in degrees [default: that of the Cornell box, {:.1}; for a mesh {DEFAULT_FOV}]",
        CornellBox::new().camera.field_of_view().to_degrees()
    ))]
    fov: Option<f64>,
    /// Corners of the lamp for --integral light, counterclockwise as seen from its lit side [default: that of the Cornell box]
    #[arg(long, value_name = "X,Y,Z,...", allow_hyphen_values = true)]
    lamp: Option<Numbers<12, f64>>,
}

/// The scene that the flags describe.
pub(super) struct Stage {
    scene: Scene,
    camera: Camera,
    size: [usize; 2],
    region: Option<CropWindow>,
    pixel_rays: usize,
    /// The upward direction.
    up: DVec3,
    integral: RequestedIntegral,
    /// Everything that a reference image depends on except its directions, in words and hashes.
    pub(super) description: String,
}

/// An [`Integral`] with the data that it borrows.
enum RequestedIntegral {
    Ambient { max_distance: f64, cosine: bool },
    Irradiance { environment: EnvironmentMap, to_map: DQuat, albedo: f64 },
    Light { light: Quad, albedo: f64 },
}

impl StageArgs {
    /// Reads the files and checks the numbers.
    ///
    /// Reports remarks on the files.
    pub(super) fn stage(&self, default_size: usize, session: &Session) -> Result<Stage, CliError> {
        let wrong = |error: sphvar_scene::Error| CliError::usage(error);
        let up = self.up.map_or(DVec3::Y, |up| DVec3::from_array(up.0));
        let mut description = String::new();
        let (scene, own_camera, own_light) = if self.scene == "cornell" {
            description.push_str("scene cornell");
            let CornellBox { scene, camera, light } = CornellBox::new();
            (scene, Some(camera), Some(light))
        } else {
            let (scene, hash) = self.mesh(session)?;
            description.push_str(&format!("scene obj {hash}"));
            (scene, None, None)
        };
        let camera = self.camera(&scene, own_camera, up)?;
        let size = self.size.map_or([default_size; 2], |size| size.0);
        let region = self.crop.map(|crop| {
            let [x, y, width, height] = crop.0;
            CropWindow { x, y, width, height }
        });
        let own_light = match &self.lamp {
            Some(lamp) => {
                let corner = |i: usize| DVec3::from_slice(&lamp.0[3 * i..]);
                Some(Quad::new([0, 1, 2, 3].map(corner)).map_err(wrong)?)
            }
            None => own_light,
        };
        let (integral, words) = self.wanted(own_light, up, session)?;
        description.push_str(&format!(
            "\ncamera {camera:?}\nsize {size:?} part {region:?} rays {}\n{words}",
            self.pixel_rays
        ));
        let stage = Stage {
            scene,
            camera,
            size,
            region,
            pixel_rays: self.pixel_rays,
            up: up.try_normalize().unwrap_or(DVec3::Y),
            integral,
            description,
        };
        // Invalid sizes and crops are rejected from here on.
        stage.view()?;
        Ok(stage)
    }

    fn mesh(&self, session: &Session) -> Result<(Scene, String), CliError> {
        let path = Path::new(&self.scene);
        let name = self.scene.to_ascii_lowercase();
        let is_obj = [".obj", ".obj.gz"].iter().any(|extension| name.ends_with(extension));
        if !is_obj {
            return Err(CliError::Usage(format!(
                "unknown scene \"{}\"; there is: cornell, or a mesh in a file that ends in .obj or .obj.gz",
                self.scene
            )));
        }
        let failed = |e: &dyn std::fmt::Display| CliError::Failed(format!("{}: {e}", self.scene));
        let bytes = read_whole(path)?;
        let (mesh, remarks) = Mesh::from_obj_with_remarks(&*bytes).map_err(|e| failed(&e))?;
        for remark in remarks.to_string().lines() {
            session.say(&format!("{}: {remark}", self.scene));
        }
        Ok((Scene::from_mesh(mesh), fingerprint(&bytes)))
    }

    fn camera(&self, scene: &Scene, own: Option<Camera>, up: DVec3) -> Result<Camera, CliError> {
        let given = self.eye.is_some() || self.look_at.is_some() || self.up.is_some();
        match own {
            Some(camera) if !given && self.fov.is_none() => return Ok(camera),
            _ => (),
        }
        let bounds = scene.bounds();
        let default_fov = own.map_or(DEFAULT_FOV.to_radians(), |camera| camera.field_of_view());
        let fov = match self.fov {
            None => default_fov,
            Some(fov) if fov > 0.0 && fov < 180.0 => fov.to_radians(),
            Some(fov) => {
                return Err(CliError::Usage(format!(
                    "--fov must be a field of view above 0 and below 180 degrees, got {fov}"
                )));
            }
        };
        let target = match (self.look_at, own) {
            (Some(at), _) => DVec3::from_array(at.0),
            (None, Some(camera)) if self.eye.is_none() => camera.position() + DVec3::Z,
            _ => bounds.center(),
        };
        let eye = self.eye.map(|eye| DVec3::from_array(eye.0));
        let camera = match eye.or(own.map(|camera| camera.position())) {
            Some(eye) => Camera::look_at(eye, target, up, fov),
            None => Camera::around(&bounds, target, up, fov),
        };
        camera.map_err(CliError::usage)
    }

    fn wanted(
        &self,
        light: Option<Quad>,
        up: DVec3,
        session: &Session,
    ) -> Result<(RequestedIntegral, String), CliError> {
        let text = &self.integral;
        let mut spec = Spec::parse(text)?;
        let mut albedo = 1.0;
        if spec.name != "light" && self.lamp.is_some() {
            return Err(CliError::Usage(format!("--lamp requires --integral light, got {text}")));
        }
        if spec.name != "ao" {
            if self.max_distance.is_some() {
                return Err(CliError::Usage(format!(
                    "--max-distance requires --integral ao, got {text}"
                )));
            }
            spec.replace_number("albedo", &mut albedo)?;
            if !(0.0..=1.0).contains(&albedo) {
                return Err(CliError::Usage(format!(
                    "{text}: albedo must be in [0, 1], got {albedo}"
                )));
            }
        }
        match spec.name.as_str() {
            "ao" => {
                let max_distance = self.max_distance.unwrap_or(f64::INFINITY);
                if max_distance.is_nan() || max_distance <= 0.0 {
                    return Err(CliError::Usage(format!(
                        "--max-distance must be above 0, got {max_distance}"
                    )));
                }
                let mut cosine = false;
                spec.replace_choice(
                    "weight",
                    &[("uniform", false), ("cosine", true)],
                    &mut cosine,
                )?;
                spec.finish(&["weight (uniform, cosine)"])?;
                let words = format!("ambient {max_distance:e} {cosine}");
                Ok((RequestedIntegral::Ambient { max_distance, cosine }, words))
            }
            "irradiance" => {
                let file =
                    spec.take_path("env").or_else(|| spec.take_path("")).ok_or_else(|| {
                        CliError::Usage(format!(
                            "{text}: missing parameter env: irradiance:env=FILE"
                        ))
                    })?;
                // The file may be written in the notation of an integrand.
                let file = match file.to_str().and_then(|file| file.strip_prefix("env:")) {
                    Some(inner) if !file.exists() => PathBuf::from(inner),
                    _ => file,
                };
                let mut picture = PictureParameters::default();
                let keys = sphvar_grammar::take(&mut picture, &mut spec)?;
                let known = ["env", "albedo"].into_iter().chain(keys.iter().map(String::as_str));
                spec.finish(&known.collect::<Vec<_>>())?;
                let source = PictureSource::open(&file, session)?;
                let Environment { map, words, remarks } =
                    Environment::decode(&file, &source, &picture)?;
                let pole = picture.up.map(UpAxis::direction);
                remarks.iter().for_each(|text| session.remark(text));
                let up = pole.or(up.try_normalize()).unwrap_or(DVec3::Y);
                let to_map = to_map(up);
                let hash = fingerprint(&source.bytes());
                let words = format!("irradiance {hash} {words} {albedo:e} {to_map:?}");
                let environment = map;
                Ok((RequestedIntegral::Irradiance { environment, to_map, albedo }, words))
            }
            "light" => {
                spec.finish(&["albedo"])?;
                let light = light.ok_or_else(|| {
                    CliError::Usage(format!(
                        "{text}: missing option --lamp, because a mesh has no lamp"
                    ))
                })?;
                Ok((
                    RequestedIntegral::Light { light, albedo },
                    format!("light {light:?} {albedo:e}"),
                ))
            }
            name => Err(unknown_name("integral", name, &["ao", "irradiance", "light"])),
        }
    }
}

impl Stage {
    /// Returns the requested part of the picture.
    pub(super) fn view(&self) -> Result<View<'_>, CliError> {
        let view = View::new(&self.scene, &self.camera, self.size)
            .and_then(|view| view.with_rays_per_side(self.pixel_rays))
            .and_then(|view| match self.region {
                Some(region) => view.with_region(region),
                None => Ok(view),
            });
        view.map_err(CliError::usage)
    }

    /// Calls `then` with the integral.
    pub(super) fn with_integral<T>(&self, then: impl FnOnce(&Integral<'_>) -> T) -> T {
        match &self.integral {
            &RequestedIntegral::Ambient { max_distance, cosine } => {
                then(&Integral::AmbientOcclusion { max_distance, cosine })
            }
            RequestedIntegral::Irradiance { environment, to_map, albedo } => {
                let radiance = |dir: DVec3| environment.eval(*to_map * dir);
                then(&Integral::Irradiance { radiance: &radiance, albedo: *albedo })
            }
            RequestedIntegral::Light { light, albedo } => {
                then(&Integral::Light { light, albedo: *albedo })
            }
        }
    }

    /// Returns the light, if it is integrated.
    pub(super) fn light(&self) -> Option<&Quad> {
        match &self.integral {
            RequestedIntegral::Light { light, .. } => Some(light),
            _ => None,
        }
    }

    /// Returns the rotation from an environment map, with its pole at +z, to the scene.
    pub(super) fn rotation_of_map(&self) -> DQuat {
        match &self.integral {
            RequestedIntegral::Irradiance { to_map, .. } => to_map.inverse(),
            _ => to_map(self.up).inverse(),
        }
    }

    /// Returns densities from which the integral is estimated with a small variance, whatever the
    /// scene: that of the light, or those of the cosine and of the map; `None` for ambient occlusion.
    pub(super) fn densities(&self) -> Option<Vec<(Density, f64)>> {
        match &self.integral {
            RequestedIntegral::Ambient { .. } => None,
            RequestedIntegral::Irradiance { environment, to_map, .. } => {
                let mut densities = vec![(Density::cosine(), 1.0)];
                // A black map has no density.
                if let Ok(map) = environment.clone().into_density(Interpolation::Bilinear) {
                    let rotation = to_map.inverse();
                    densities.push((Density::World { warp: Arc::new(map), rotation }, 1.0));
                }
                Some(densities)
            }
            RequestedIntegral::Light { light, .. } => {
                Some(vec![(Density::Light { light: *light, map: LightMap::Automatic }, 1.0)])
            }
        }
    }

    /// Returns whether the value 1 means that a point is reached from all directions.
    pub(super) fn is_share(&self) -> bool {
        matches!(self.integral, RequestedIntegral::Ambient { .. })
    }
}
