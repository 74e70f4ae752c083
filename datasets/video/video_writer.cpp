#include "datasets/video/video_writer.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ratio>
#include <stdexcept>
#include <string>

#include <fmt/format.h>

#include "datasets/video/internal/libav.h"
#include "scene/whole_file.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

// All usual rates divide it, those of television (24, 30 and 60 in 1.001 s) too.
constexpr int kMp4TicksPerSecond = 120'000;

// FFV1 keeps RGB without conversion; H.264 halves colours where the sides are even.
AVPixelFormat PixelFormatFor(const VideoFormat& video) {
  if (video.codec == VideoCodec::kFfv1) return video.is_grey ? AV_PIX_FMT_GRAY8 : AV_PIX_FMT_0RGB32;
  const bool is_even = video.width_px % 2 == 0 && video.height_px % 2 == 0;
  return is_even ? AV_PIX_FMT_YUV420P : AV_PIX_FMT_YUV444P;
}

}  // namespace

struct VideoWriter::Impl {
  std::filesystem::path file;
  AVFormatContext* container = nullptr;
  AVStream* stream = nullptr;
  LibavPointer<AVCodecContext> encoder;
  LibavPointer<AVFrame> frame;
  LibavPointer<AVPacket> packet{av_packet_alloc()};
  LibavPointer<SwsContext> to_yuv;  // H.264 alone.
  bool is_mp4 = false;
  std::int64_t last_tick = -1;
  std::int64_t good_bytes = 0;  // With all pictures so far.
  bool has_failed = true;       // Until the file has its header.

  [[noreturn]] void Refuse(const std::string& what, int error) const {
    RefuseFile(file, what + ": " + LibavError(error));
  }
  void Check(int result, const char* what) const {
    if (result < 0) Refuse(what, result);
  }

  void Open(const VideoFormat& video) {
    SilenceLibav();
    if (video.container == VideoContainer::kMp4 &&
        !(video.frames_per_second > 0.0 && std::isfinite(video.frames_per_second))) {
      throw std::invalid_argument(fmt::format(
          "{}: {} pictures a second, expected more", file.string(), video.frames_per_second));
    }
    if (std::filesystem::exists(file)) RefuseFile(file, "expected a new file, found one");
    const AVCodec* found = avcodec_find_encoder(
        video.codec == VideoCodec::kFfv1 ? AV_CODEC_ID_FFV1 : AV_CODEC_ID_H264);
    if (found == nullptr) RefuseFile(file, "expected FFmpeg with the encoder, found none");
    is_mp4 = video.container == VideoContainer::kMp4;
    const char* const format = is_mp4 ? "mp4" : "matroska";
    Check(avformat_alloc_output_context2(&container, nullptr, format, file.c_str()), "video");
    encoder.reset(avcodec_alloc_context3(found));
    encoder->width = video.width_px;
    encoder->height = video.height_px;
    encoder->pix_fmt = PixelFormatFor(video);
    encoder->time_base = {1, is_mp4 ? kMp4TicksPerSecond : 1000};
    // The encoder states by it how fast a player has to be.
    if (is_mp4) encoder->framerate = av_d2q(video.frames_per_second, 100'000);
    encoder->thread_count = 1;
    if ((container->oformat->flags & AVFMT_GLOBALHEADER) != 0) {
      encoder->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    }
    AVDictionary* options = nullptr;
    if (video.codec == VideoCodec::kFfv1) {
      encoder->gop_size = 1;
      // Checksums: VideoReader finds damage.
      av_dict_set(&options, "level", "3", 0);
      av_dict_set(&options, "slicecrc", "1", 0);
      av_dict_set(&container->metadata, kHasSliceChecksums, "1", 0);
    } else {
      encoder->gop_size = 60;
      encoder->colorspace = AVCOL_SPC_SMPTE170M;
      encoder->color_range = AVCOL_RANGE_MPEG;
      // Each picture is complete at once: no picture waits for later ones.
      av_dict_set(&options, "preset", "veryfast", 0);
      av_dict_set(&options, "tune", "zerolatency", 0);
      av_dict_set(&options, "crf", "20", 0);
      to_yuv.reset(sws_getContext(video.width_px,
                                  video.height_px,
                                  AV_PIX_FMT_RGB24,
                                  video.width_px,
                                  video.height_px,
                                  encoder->pix_fmt,
                                  SWS_BILINEAR | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INP,
                                  nullptr,
                                  nullptr,
                                  nullptr));
    }
    const int opened = avcodec_open2(encoder.get(), found, &options);
    av_dict_free(&options);
    Check(opened, "expected an encoder for such pictures");
    frame.reset(av_frame_alloc());
    frame->width = video.width_px;
    frame->height = video.height_px;
    frame->format = encoder->pix_fmt;
    Check(av_frame_get_buffer(frame.get(), 0), "video");
    stream = avformat_new_stream(container, nullptr);
    stream->time_base = encoder->time_base;
    Check(avcodec_parameters_from_context(stream->codecpar, encoder.get()), "video");
    if (video.start != UtcTime{}) {
      const UtcTime start = std::chrono::floor<std::chrono::milliseconds>(video.start);
      av_dict_set(&container->metadata, "creation_time", FormatUtcTime(start).c_str(), 0);
    }
    Check(avio_open(&container->pb, LibavUrl(file).c_str(), AVIO_FLAG_WRITE), "cannot be made");
    Check(avformat_write_header(container, nullptr), "cannot be written");
    Flush();
    has_failed = false;
  }

  ~Impl() {
    if (container == nullptr) return;
    const bool is_open = container->pb != nullptr;
    if (is_open && !has_failed) av_write_trailer(container);
    if (is_open) avio_closep(&container->pb);
    avformat_free_context(container);
    std::error_code ignored;
    if (is_open && good_bytes == 0) {
      std::filesystem::remove(file, ignored);  // Not even its header could be written.
    } else if (has_failed && good_bytes > 0) {
      std::filesystem::resize_file(file, static_cast<std::uintmax_t>(good_bytes), ignored);
    }
  }

  void Finish() {
    if (container == nullptr || container->pb == nullptr) return;
    if (has_failed) RefuseFile(file, "cannot be written any more");
    has_failed = true;  // Until all of it has gone well.
    const int ended = av_write_trailer(container);
    const int flushed = container->pb->error;
    const int closed = avio_closep(&container->pb);
    for (const int result : {ended, flushed, closed}) Check(result, "cannot be written");
    has_failed = false;
  }

  std::int64_t TickOf(std::chrono::nanoseconds time) const {
    if (is_mp4) return av_rescale(time.count(), kMp4TicksPerSecond, std::nano::den);
    return std::chrono::floor<std::chrono::milliseconds>(time).count();
  }

  void Flush() {
    avio_flush(container->pb);
    Check(container->pb->error, "cannot be written");
    good_bytes = avio_seek(container->pb, 0, SEEK_CUR);
  }

  void Fill(const Rgb8Image& picture) {
    Check(av_frame_make_writable(frame.get()), "video");
    if (to_yuv) {
      const auto* rgb = reinterpret_cast<const std::uint8_t*>(picture.pixels.data());
      const int stride = 3 * picture.width;
      sws_scale(to_yuv.get(), &rgb, &stride, 0, picture.height, frame->data, frame->linesize);
      return;
    }
    const bool is_grey = frame->format == AV_PIX_FMT_GRAY8;
    for (int y = 0; y < picture.height; ++y) {
      std::uint8_t* row = frame->data[0] + std::ptrdiff_t{y} * frame->linesize[0];
      for (int x = 0; x < picture.width; ++x) {
        const glm::u8vec3& code = picture.At(x, y);
        if (is_grey) {
          row[x] = code.r;
          continue;
        }
        const std::uint32_t rgb =
            (std::uint32_t{code.r} << 16) | (std::uint32_t{code.g} << 8) | std::uint32_t{code.b};
        std::memcpy(row + 4 * x, &rgb, sizeof rgb);
      }
    }
  }

  void Write() {
    Check(avcodec_send_frame(encoder.get(), frame.get()), "cannot be encoded");
    Check(avcodec_receive_packet(encoder.get(), packet.get()), "cannot be encoded");
    // Matroska has each picture last until the next one; MP4's last one else lasts no time.
    if (is_mp4) {
      packet->duration = av_rescale_q(1, av_inv_q(encoder->framerate), encoder->time_base);
    }
    av_packet_rescale_ts(packet.get(), encoder->time_base, stream->time_base);
    packet->stream_index = stream->index;
    Check(av_write_frame(container, packet.get()), "cannot be written");
    av_packet_unref(packet.get());
    // Matroska else collects pictures until there are some megabytes of them.
    Check(av_write_frame(container, nullptr), "cannot be written");
    Flush();
  }
};

VideoWriter::VideoWriter(const std::filesystem::path& file, const VideoFormat& format)
    : impl_(std::make_unique<Impl>()) {
  impl_->file = file;
  impl_->Open(format);
}

VideoWriter::~VideoWriter() = default;

void VideoWriter::Finish() { impl_->Finish(); }

std::uint64_t VideoWriter::Add(const Rgb8Image& picture, std::chrono::nanoseconds time) {
  AVFrame& frame = *impl_->frame;
  if (picture.width != frame.width || picture.height != frame.height) {
    throw std::invalid_argument(fmt::format("video picture: expected {}x{}, found {}x{}",
                                            frame.width,
                                            frame.height,
                                            picture.width,
                                            picture.height));
  }
  if (impl_->has_failed || impl_->container->pb == nullptr) {
    RefuseFile(impl_->file, "cannot be written any more");
  }
  const std::int64_t before = impl_->good_bytes;
  frame.pts = std::max<std::int64_t>(impl_->TickOf(time), impl_->last_tick + 1);
  impl_->last_tick = frame.pts;
  try {
    impl_->Fill(picture);
    impl_->Write();
  } catch (...) {
    impl_->has_failed = true;
    throw;
  }
  return static_cast<std::uint64_t>(impl_->good_bytes - before);
}

}  // namespace pleinair
