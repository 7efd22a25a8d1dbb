//! The command `wavelet-tex encode`.

use std::{
    fs,
    hash::{DefaultHasher, Hash, Hasher},
    path::{Path, PathBuf},
    time::Instant,
};

use bevy_wavelet_tex::{
    codec::{
        encoder::encode,
        image::{Content, WaveletImage},
        settings::{EncodeSettings, GrayChannel},
        source::Source,
    },
    file,
};
use serde::Serialize;

use crate::{
    Error,
    args::{EncodeArgs, Role},
    batch::{self, Batch, Report},
    files::{self, Destination},
    measure::Difference,
    picture::{self, Picture},
    plan::{GLTF_EXTENSIONS, Gltf, Origin, Plan, RoleSource, Task},
    settings::{ImageSettings, Patterns},
};

/// Encodes images and the images of glTF files, and says a line about each.
pub fn run(args: &EncodeArgs) -> Result<Report, Error> {
    args.check()?;
    let patterns = match &args.roles {
        Some(file) => Patterns::read(file)?,
        None => Patterns::default(),
    };
    let is_texture = |path: &Path| files::has_extension(path, &[file::EXTENSION]);
    let (named, out) = files::split_output(&args.inputs, args.out.as_deref(), is_texture);
    let single = files::is_single(named) && !files::has_extension(&named[0], GLTF_EXTENSIONS);
    let destination = Destination::new(out, single, file::EXTENSION)?;
    let extensions = [picture::EXTENSIONS, GLTF_EXTENSIONS].concat();
    let (inputs, errors) = files::expand(named, &extensions);
    let plan = Plan::new(&inputs, errors, &destination, args.role, &patterns);
    if plan.tasks.is_empty() && plan.errors.is_empty() {
        let others = plan
            .left
            .iter()
            .filter(|(_, others)| !others.is_empty())
            .map(|(_, others)| format!(", but for {others}"));
        return Err(Error::file(
            &named[0],
            format_args!(
                "there is nothing to encode: no material has a map{}",
                others.collect::<String>()
            ),
        ));
    }
    let mut encoder = Encoder::new(args, destination.makes_folders());
    let (rows, result) = batch::run(
        &plan.tasks,
        plan.errors,
        |task| &task.label,
        |task, batch| {
            let row = encoder.encode(task, batch)?;
            if !args.json {
                batch.say(&row.text());
            }
            Ok(row)
        },
    );
    for (path, others) in &plan.left {
        match others.as_str() {
            "" => batch::warn(path, "no material has a map"),
            _ => batch::warn(path, &format!("the maps of {others} keep their own images")),
        }
    }
    let text = if args.json {
        serde_json::to_string_pretty(&rows).expect("plain data")
    } else {
        count(&rows)
    };
    Ok((text, result))
}

/// How many files were encoded, where there are several.
fn count(rows: &[Row]) -> String {
    let unchanged = rows.iter().filter(|row| row.unchanged).count();
    match (rows.len() - unchanged, unchanged) {
        (0 | 1, 0) | (0, 1) => String::new(),
        (encoded, 0) => format!("{encoded} files encoded"),
        (encoded, unchanged) => format!("{encoded} files encoded, {unchanged} unchanged"),
    }
}

/// The result of one image.
#[derive(Serialize)]
struct Row {
    input: String,
    output: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    role: Option<&'static str>,
    content: &'static str,
    /// The channel that gray is made of, where it is not luma.
    #[serde(skip_serializing_if = "Option::is_none")]
    channel: Option<&'static str>,
    /// The packing of luma, or the format and size of a plain texture.
    packing: String,
    size: [u32; 2],
    levels: u32,
    bpp: f64,
    bytes: usize,
    /// Whether the file was there already, made of the same image with the same options.
    unchanged: bool,
    #[serde(flatten)]
    measured: Option<Measured>,
    /// Why the image has its role, for people.
    #[serde(skip)]
    role_note: &'static str,
}

/// What is known of an image that was encoded now.
#[derive(Serialize)]
struct Measured {
    psnr_db: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    mean_angle_degrees: Option<f64>,
    encode_s: f64,
    #[serde(skip)]
    quality: String,
}

impl Row {
    fn text(&self) -> String {
        let [width, height] = self.size;
        let role = self.role.map_or(String::new(), |role| {
            let of = self.channel.map_or(String::new(), |c| format!(" of {c}"));
            format!("{role}{of}{}, ", self.role_note)
        });
        let start = format!(
            "{}: {width} x {height} pixels, {role}{}, {:.2} bpp, {} bytes",
            self.output, self.packing, self.bpp, self.bytes,
        );
        match &self.measured {
            Some(Measured {
                quality, encode_s, ..
            }) => format!("{start}, {quality}, {encode_s:.2} s"),
            None => format!("{start}, unchanged"),
        }
    }
}

/// Encodes images one after the other.
struct Encoder<'a> {
    args: &'a EncodeArgs,
    makes_folders: bool,
    /// The glTF file of the last image, which is often that of the next.
    gltf: Option<(PathBuf, Gltf)>,
}

impl<'a> Encoder<'a> {
    fn new(args: &'a EncodeArgs, makes_folders: bool) -> Self {
        Self {
            args,
            makes_folders,
            gltf: None,
        }
    }

    fn encode(&mut self, task: &Task, batch: &Batch) -> Result<Row, Error> {
        let args = self.args;
        let bytes = self.bytes(task)?;
        files::check_output(
            &task.output,
            self.makes_folders,
            args.force,
            file::is_texture,
        )?;
        let fingerprint = fingerprint(&bytes, task, args);
        if !args.force
            && let Some(row) = unchanged(task, fingerprint)
        {
            return Ok(row);
        }
        let path = match &task.origin {
            Origin::File(path) => path,
            Origin::Gltf { .. } => &task.label,
        };
        let mut picture = picture::decode(path, &bytes)?;
        drop(bytes);
        let ImageSettings {
            settings,
            role,
            warnings,
        } = args.image_settings(&picture, task)?;
        for warning in warnings {
            batch.warn(&task.label, &warning);
        }
        if settings.rate.content(false) == Content::Normal {
            picture.complete_normals();
        }
        if let Some(most) = args.max_size
            && picture.size.iter().any(|s| *s > most)
        {
            picture = picture.reduced(most, settings.color_space);
        }
        let start = Instant::now();
        let texture = encoded(&task.label, &picture, &settings)?;
        let encode_s = start.elapsed().as_secs_f64();
        let bytes = match args.zstd {
            Some(level) => file::write_zstd(&texture, level),
            None => file::write(&texture),
        };
        let bytes = file::with_fingerprint(bytes, fingerprint);
        files::write(&task.output, &bytes)?;
        picture.take_channel(settings.gray);
        picture.has_alpha &= texture.content == Content::ColorAlpha;
        let difference = Difference::between(&picture, &Picture::from_texture(&texture, 0), false);
        if let Some(min_psnr_db) = settings.min_psnr_db
            && difference.psnr_db < min_psnr_db
        {
            let problem = format!(
                "the largest rate reaches {:.2} dB, not {min_psnr_db}",
                difference.psnr_db
            );
            batch.warn(&task.label, &problem);
        }
        let measured = Measured {
            psnr_db: difference.psnr_db,
            mean_angle_degrees: difference.angles.as_ref().map(|a| a.mean_angle_degrees),
            encode_s,
            quality: difference.quality(),
        };
        let mut row = row(task, role, &texture, bytes.len(), Some(measured));
        row.channel = match settings.gray {
            GrayChannel::Luma => None,
            GrayChannel::Red => Some("red"),
            GrayChannel::Alpha => Some("alpha"),
        };
        Ok(row)
    }

    fn bytes(&mut self, task: &Task) -> Result<Vec<u8>, Error> {
        let (file, image) = match &task.origin {
            Origin::File(path) if path.exists() => return files::read(path),
            Origin::File(_) => return files::read(&task.label),
            Origin::Gltf { file, image } => (file, *image),
        };
        if self.gltf.as_ref().is_none_or(|(path, _)| path != file) {
            self.gltf = Some((file.clone(), Gltf::read(file)?));
        }
        let (_, gltf) = self.gltf.as_ref().expect("it was read");
        gltf.image(image)
    }
}

/// What the result depends on: the image and all that is asked of it.
fn fingerprint(bytes: &[u8], task: &Task, args: &EncodeArgs) -> u64 {
    let mut hasher = DefaultHasher::new();
    bytes.hash(&mut hasher);
    env!("CARGO_PKG_VERSION").hash(&mut hasher);
    let asked = (
        (task.role, task.alpha, task.cutoff),
        (&args.rate, args.min_psnr, args.encoder, args.linear),
        (
            args.alpha,
            args.cutoff,
            args.max_size,
            args.no_mips,
            args.zstd,
        ),
    );
    format!("{asked:?}").hash(&mut hasher);
    hasher.finish()
}

/// The result that is there already, where it is that of the same image and options.
fn unchanged(task: &Task, expected: u64) -> Option<Row> {
    let bytes = fs::read(&task.output).ok()?;
    if file::fingerprint(&bytes)? != expected {
        return None;
    }
    let texture = file::read(&bytes).ok()?;
    Some(row(task, task.role, &texture, bytes.len(), None))
}

fn row(
    task: &Task,
    role: Option<(Role, RoleSource)>,
    texture: &WaveletImage,
    bytes: usize,
    measured: Option<Measured>,
) -> Row {
    Row {
        // JSON has no names that are not UTF-8.
        input: task.label.to_string_lossy().into(),
        output: task.output.to_string_lossy().into(),
        role: role.map(|(role, _)| role.name()),
        content: texture.content.name(),
        channel: None,
        packing: texture.storage_name(),
        size: texture.size,
        levels: texture.levels,
        bpp: texture.bits_per_pixel(),
        bytes,
        unchanged: measured.is_none(),
        measured,
        role_note: match role {
            Some((_, RoleSource::Name)) => " (by its name)",
            _ => "",
        },
    }
}

fn encoded(
    path: &Path,
    picture: &Picture,
    settings: &EncodeSettings,
) -> Result<WaveletImage, Error> {
    let bar = batch::bar("mip levels");
    let source = Source::new(picture.size, picture.source());
    let texture = encode(&source, settings, &|_, parts| {
        bar.set_length(parts as u64);
        bar.inc(1);
    });
    bar.finish_and_clear();
    texture.map_err(|e| Error::file(path, e))
}
