//! Films: AV1 in MP4.

use crate::Picture;
use crate::yuv::Yuv;
use rav1e::prelude::{
    ChromaSamplePosition, ColorDescription, ColorPrimaries, Config, Context, EncoderConfig, EncoderStatus,
    FrameType, MatrixCoefficients, Packet, PartitionRange, Rational, SceneDetectionSpeed,
    TransferCharacteristics, Tune,
};
use shiguredo_mp4::bitstream::av1::{
    Av1ObuParseContext, Av1ObuType, Av1SampleEntryConfig, build_av01_box_from_config_obus, parse_obus,
};
use shiguredo_mp4::boxes::{Av01Box, SampleEntry, UnknownBox};
use shiguredo_mp4::mux::{Mp4FileMuxer, Mp4FileMuxerOptions, Sample, estimate_maximum_moov_box_size};
use shiguredo_mp4::{BoxSize, BoxType, TrackKind};
use std::fmt::Display;
use std::io::{self, Seek, SeekFrom, Write};
use std::num::NonZeroU32;

/// The fastest of rav1e's presets. Rhytid builds rav1e without its assembler, which needs NASM. The other
/// presets then take several times as long.
const SPEED: u8 = 10;
/// The quantizer, from 0 (lossless) to 255. This value keeps wrinkles and shows smooth skin.
const QUANTIZER: usize = 40;
/// Tiles are encoded in parallel. Each has about this many pixels.
const PIXELS_PER_TILE: u64 = 100_000;
/// The time from one key frame to the next. A player can jump to key frames.
const SECONDS_BETWEEN_KEYS: f64 = 2.0;
/// AV1's number for a stream without a level.
const ANY_LEVEL: u8 = 31;

/// A film in AV1 (by [rav1e](https://docs.rs/rav1e)), in an MP4 file whose index comes first. It is written
/// picture by picture, with the memory of a few pictures. Its colours are those of sRGB, in BT.709's Y'CbCr
/// of limited range. The colour differences have half the resolution along each side (4:2:0). Both the stream
/// and the file state this. The same pictures give the same bytes, on any number of threads.
pub struct Film<W: Write + Seek> {
    out: W,
    encoder: Context<u8>,
    yuv: Yuv,
    muxer: Mp4FileMuxer,
    /// Whether the description of the stream has been written.
    entry_is_written: bool,
    /// Ticks a second, and ticks a picture.
    time_base: (NonZeroU32, u32),
    /// Bytes of `out`.
    written: u64,
}

impl<W: Write + Seek> Film<W> {
    /// The least and the most pixels along a side.
    pub const SIDES: [u32; 2] = [16, 65_535];

    /// Begins a film of `pictures` pictures, at least one, of `size` pixels. It shows `rate` pictures a
    /// second (0.1 to 600). `out` is at its beginning.
    ///
    /// # Errors
    /// Errors of `out`; [`io::ErrorKind::InvalidInput`] where a side is outside of [`Film::SIDES`].
    pub fn new(mut out: W, size: [u32; 2], pictures: u32, rate: f64) -> io::Result<Self> {
        let (ticks, ticks_per_picture) = time_base(rate);
        let [width, height] = size.map(|side| side as usize);
        let mut wanted = EncoderConfig::with_speed_preset(SPEED);
        (wanted.width, wanted.height) = (width, height);
        wanted.time_base = Rational::new(ticks_per_picture.into(), ticks.get().into());
        wanted.quantizer = QUANTIZER;
        wanted.tiles = (u64::from(size[0]) * u64::from(size[1])).div_ceil(PIXELS_PER_TILE) as usize;
        // Pictures come out in the order in which they go in, and none is kept to look ahead.
        wanted.low_latency = true;
        wanted.speed_settings.rdo_lookahead_frames = 1;
        wanted.speed_settings.scene_detection_mode = SceneDetectionSpeed::None;
        let between_keys = (SECONDS_BETWEEN_KEYS * rate).ceil().clamp(1.0, 1200.0) as u64;
        wanted.set_key_frame_interval(between_keys, between_keys);
        // This halves the bytes of the preset's own choice, in the same time.
        wanted.tune = Tune::Psnr;
        wanted.speed_settings.partition.partition_range = PartitionRange::new(
            rav1e::prelude::BlockSize::BLOCK_16X16,
            rav1e::prelude::BlockSize::BLOCK_16X16,
        );
        wanted.chroma_sample_position = ChromaSamplePosition::Vertical;
        wanted.color_description = Some(ColorDescription {
            color_primaries: ColorPrimaries::BT709,
            transfer_characteristics: TransferCharacteristics::SRGB,
            matrix_coefficients: MatrixCoefficients::BT709,
        });
        // The lowest level that fits the film. A hardware decoder may refuse a stream without a level.
        let of_level = |level| {
            let config = EncoderConfig { level_idx: Some(level), ..wanted.clone() };
            Some(Config::new().with_encoder_config(config)).filter(|config| config.validate().is_ok())
        };
        let config = (0..=ANY_LEVEL).find_map(of_level);
        let config = config.unwrap_or_else(|| Config::new().with_encoder_config(wanted.clone()));
        let encoder =
            config.new_context().map_err(|e| io::Error::new(io::ErrorKind::InvalidInput, e.to_string()))?;
        let options = Mp4FileMuxerOptions {
            reserved_moov_box_size: estimate_maximum_moov_box_size(&[pictures as usize]),
            ..Mp4FileMuxerOptions::default()
        };
        let muxer = Mp4FileMuxer::with_options(options).map_err(refused)?;
        let head = muxer.initial_boxes_bytes();
        out.write_all(head)?;
        Ok(Self {
            written: head.len() as u64,
            out,
            encoder,
            yuv: Yuv::new(size),
            muxer,
            entry_is_written: false,
            time_base: (ticks, ticks_per_picture),
        })
    }

    /// Adds the next picture. Its opacity is ignored.
    ///
    /// # Errors
    /// Errors of `out`; [`io::ErrorKind::InvalidInput`] if the picture has another size.
    pub fn add(&mut self, picture: &Picture) -> io::Result<()> {
        if picture.size != self.yuv.size() {
            let what = format!("a picture of {:?} pixels among those of {:?}", picture.size, self.yuv.size());
            return Err(io::Error::new(io::ErrorKind::InvalidInput, what));
        }
        let mut frame = self.encoder.new_frame();
        for (plane, (numbers, width)) in frame.planes.iter_mut().zip(self.yuv.planes(picture)) {
            plane.copy_from_raw_u8(numbers, width, 1);
        }
        self.encoder.send_frame(frame).map_err(refused)?;
        self.write_packets()
    }

    /// Writes the remaining pictures, and the index.
    ///
    /// # Errors
    /// Errors of `out`.
    pub fn finish(mut self) -> io::Result<()> {
        self.encoder.flush();
        self.write_packets()?;
        for (at, bytes) in self.muxer.finalize().map_err(refused)?.offset_and_bytes_pairs() {
            self.out.seek(SeekFrom::Start(at))?;
            self.out.write_all(bytes)?;
        }
        Ok(())
    }

    /// Writes the packets that the encoder has finished.
    fn write_packets(&mut self) -> io::Result<()> {
        loop {
            match self.encoder.receive_packet() {
                Ok(packet) => self.write(&packet)?,
                Err(EncoderStatus::Encoded) => {}
                Err(EncoderStatus::NeedMoreData | EncoderStatus::LimitReached) => return Ok(()),
                Err(other) => return Err(refused(other)),
            }
        }
    }

    /// Writes the units of one picture without the delimiter, which files do not have.
    fn write(&mut self, packet: &Packet<u8>) -> io::Result<()> {
        let units = parse_obus(&packet.data, Av1ObuParseContext::Sample).map_err(refused)?;
        let is_delimiter = |of: Av1ObuType| of == Av1ObuType::TemporalDelimiter;
        let mut size = 0;
        for unit in units.iter().filter(|unit| !is_delimiter(unit.obu_type)) {
            self.out.write_all(unit.obu)?;
            size += unit.obu.len();
        }
        let header = units.iter().find(|unit| unit.obu_type == Av1ObuType::SequenceHeader);
        let entry = match header.filter(|_| !self.entry_is_written) {
            Some(header) => Some(SampleEntry::Av01(entry(header.obu)?)),
            None => None,
        };
        self.entry_is_written |= entry.is_some();
        let sample = Sample {
            track_kind: TrackKind::Video,
            sample_entry: entry,
            keyframe: packet.frame_type == FrameType::KEY,
            timescale: self.time_base.0,
            duration: self.time_base.1,
            composition_time_offset: None,
            data_offset: self.written,
            data_size: size,
        };
        self.written += size as u64;
        self.muxer.append_sample(&sample).map_err(refused)
    }
}

/// The description of the stream for the file: its sequence header, and its colours (`colr`) by the numbers
/// of ISO/IEC 23091-2.
fn entry(sequence_header: &[u8]) -> io::Result<Av01Box> {
    let config = Av1SampleEntryConfig { initial_presentation_delay_minus_one: None };
    let mut entry = build_av01_box_from_config_obus(sequence_header, &config).map_err(refused)?;
    let numbers = [
        ColorPrimaries::BT709 as u16,
        TransferCharacteristics::SRGB as u16,
        MatrixCoefficients::BT709 as u16,
    ];
    let mut payload = b"nclx".to_vec();
    payload.extend(numbers.into_iter().flat_map(u16::to_be_bytes));
    // The range is not full.
    payload.push(0);
    let box_type = BoxType::Normal(*b"colr");
    let box_size = BoxSize::with_payload_size(box_type, payload.len() as u64);
    entry.unknown_boxes.push(UnknownBox { box_type, box_size, payload });
    Ok(entry)
}

/// Ticks a second and ticks a picture: exact for whole rates and multiples of 1000/1001, else within a
/// thousandth of a picture a second.
fn time_base(rate: f64) -> (NonZeroU32, u32) {
    let rate = rate.clamp(0.1, 600.0);
    let near = |x: f64| (x - x.round()).abs() < 1e-6 * x;
    let (ticks, per_picture) = match rate {
        _ if near(rate) => (rate, 1),
        _ if near(1.001 * rate) => (1001.0 * rate, 1001),
        _ => (1000.0 * rate, 1000),
    };
    (NonZeroU32::new(ticks.round() as u32).unwrap_or(NonZeroU32::MIN), per_picture)
}

/// The error of the encoder or of the writer of MP4, which means a fault in Rhytid.
fn refused(what: impl Display) -> io::Error {
    io::Error::other(format!("the film: {what}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    fn film(size: [u32; 2]) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        let mut film = Film::new(&mut bytes, size, 5, 2.0).unwrap();
        assert!(film.add(&Picture::filled([4, 4], [0; 4])).is_err());
        for i in 0..5 {
            let mut picture = Picture::filled(size, [200, 90, 30, 255]);
            picture.put(&Picture::filled([40, 40], [10, 200, 250, 255]), [20 * i, 9 * i]);
            film.add(&picture).unwrap();
        }
        film.finish().unwrap();
        bytes.into_inner()
    }

    // The tests in crates/cli/tests check that other programs read films.
    #[test]
    fn threads_do_not_show() {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| film([641, 479]))
        };
        let one = on(1);
        assert!(one == on(3));
        let at = |name: &[u8; 4]| one.windows(4).position(|four| four == name).unwrap();
        assert!(at(b"ftyp") < at(b"moov") && at(b"moov") < at(b"colr") && at(b"colr") < at(b"mdat"));
    }

    #[test]
    fn sizes_that_a_film_cannot_have_are_refused() {
        for size in [[15, 20], [20, 65_536], [0, 0]] {
            assert!(Film::new(Cursor::new(Vec::new()), size, 1, 30.0).is_err());
        }
        film([16, 17]);
    }

    #[test]
    fn rates_are_exact() {
        let base = |rate| {
            let (ticks, per_picture) = time_base(rate);
            (ticks.get(), per_picture)
        };
        assert_eq!(base(30.0), (30, 1));
        assert_eq!(base(120.0), (120, 1));
        assert_eq!(base(30_000.0 / 1001.0), (30_000, 1001));
        assert_eq!(base(24_000.0 / 1001.0), (24_000, 1001));
        assert_eq!(base(23.5), (23_500, 1000));
        assert_eq!(base(0.01), (100, 1000));
    }
}
