#include "datasets/video/video_reader.h"

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "datasets/video/internal/libav.h"
#include "scene/whole_file.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

constexpr const char* kContainers = "matroska,webm,mov,mp4,avi,mpegts,mpeg,asf,flv";
constexpr int kHighDefinitionRows = 720;
// As images of other files: 2^28 pixels.
constexpr std::int64_t kMostPixels = std::int64_t{1} << 28;

// FFV1 from version 3 on: the last bytes of each slice are its length without them (3 bytes), a
// status and a CRC that makes the slice's 0. FFmpeg's decoder detects damage but does not report
// it: it shows an older picture there.
bool HasSoundSlices(const AVPacket& packet) {
  constexpr int kTrailer = 8;
  int end = packet.size;
  while (end > 0) {
    if (end < kTrailer) return false;
    const std::uint8_t* trailer = packet.data + end - kTrailer;
    const int size = ((trailer[0] << 16) | (trailer[1] << 8) | trailer[2]) + kTrailer;
    if (size > end) return false;
    end -= size;
    const AVCRC* table = av_crc_get_table(AV_CRC_32_IEEE);
    if (av_crc(table, 0, packet.data + end, static_cast<std::size_t>(size)) != 0) return false;
  }
  return packet.size > 0;
}

}  // namespace

struct VideoReader::Impl {
  std::filesystem::path file;
  AVFormatContext* container = nullptr;
  const AVStream* stream = nullptr;
  LibavPointer<AVCodecContext> decoder;
  LibavPointer<AVFrame> frame{av_frame_alloc()};
  LibavPointer<AVPacket> packet{av_packet_alloc()};
  LibavPointer<SwsContext> to_rgb;
  bool has_slice_checksums = false;
  bool is_draining = false;

  ~Impl() {
    // Without a container its library may be absent, too.
    if (container != nullptr) avformat_close_input(&container);
  }

  void Open() {
    SilenceLibav();
    RequireFile(file);
    AVDictionary* options = nullptr;
    av_dict_set(&options, "protocol_whitelist", "file", 0);
    av_dict_set(&options, "format_whitelist", kContainers, 0);
    const int opened = avformat_open_input(&container, LibavUrl(file).c_str(), nullptr, &options);
    av_dict_free(&options);
    if (opened < 0) RefuseFile(file, "expected a video, found: " + LibavError(opened));
    if (const int read = avformat_find_stream_info(container, nullptr); read < 0) {
      RefuseFile(file, "expected a video, found: " + LibavError(read));
    }
    const AVCodec* codec = nullptr;
    const int index = av_find_best_stream(container, AVMEDIA_TYPE_VIDEO, -1, -1, &codec, 0);
    if (index < 0 || codec == nullptr) {
      RefuseFile(file, "expected a video that FFmpeg can decode, found no such stream");
    }
    stream = container->streams[index];
    decoder.reset(avcodec_alloc_context3(codec));
    avcodec_parameters_to_context(decoder.get(), stream->codecpar);
    has_slice_checksums =
        codec->id == AV_CODEC_ID_FFV1 &&
        av_dict_get(container->metadata, kHasSliceChecksums, nullptr, 0) != nullptr;
    decoder->pkt_timebase = stream->time_base;
    decoder->err_recognition = AV_EF_CRCCHECK | AV_EF_EXPLODE;
    decoder->max_pixels = kMostPixels;
    if (const int result = avcodec_open2(decoder.get(), codec, nullptr); result < 0) {
      RefuseFile(file, "expected a video that FFmpeg can decode: " + LibavError(result));
    }
    if (decoder->width < 1 || decoder->height < 1) {
      RefuseFile(file, "expected a video with pictures, found none");
    }
  }

  // Decodes into `frame`. Returns 0 for a picture, AVERROR_EOF at the end, else the error.
  int Decode() {
    for (;;) {
      const int received = avcodec_receive_frame(decoder.get(), frame.get());
      if (received != AVERROR(EAGAIN)) return received;
      if (const int sent = SendNext(); sent < 0) return sent;
    }
  }

  int SendNext() {
    for (;;) {
      const int read = is_draining ? AVERROR_EOF : av_read_frame(container, packet.get());
      if (read < 0) {
        // A file that breaks off ends there, as its pictures do.
        is_draining = true;
        return avcodec_send_packet(decoder.get(), nullptr);
      }
      if (packet->stream_index != stream->index) {
        av_packet_unref(packet.get());
        continue;
      }
      const int sent = has_slice_checksums && !HasSoundSlices(*packet)
                           ? AVERROR_INVALIDDATA
                           : avcodec_send_packet(decoder.get(), packet.get());
      av_packet_unref(packet.get());
      return sent;
    }
  }

  std::chrono::nanoseconds TimeOfFrame() const {
    const std::int64_t start = stream->start_time == AV_NOPTS_VALUE ? 0 : stream->start_time;
    const std::int64_t time = frame->best_effort_timestamp;
    if (time == AV_NOPTS_VALUE) return std::chrono::nanoseconds{0};
    return std::chrono::nanoseconds(
        av_rescale_q(time - start, stream->time_base, AVRational{1, 1'000'000'000}));
  }

  Rgb8Image CodesOfFrame() {
    Rgb8Image codes(frame->width, frame->height);
    if (frame->format == AV_PIX_FMT_0RGB32 || frame->format == AV_PIX_FMT_GRAY8) {
      CopyExactly(codes);
      return codes;
    }
    SetUpConversion();
    auto* rgb = reinterpret_cast<std::uint8_t*>(codes.pixels.data());
    const int stride = 3 * codes.width;
    sws_scale(to_rgb.get(), frame->data, frame->linesize, 0, frame->height, &rgb, &stride);
    return codes;
  }

  // The data that VideoWriter stores.
  void CopyExactly(Rgb8Image& codes) const {
    for (int y = 0; y < codes.height; ++y) {
      const std::uint8_t* row = frame->data[0] + std::ptrdiff_t{y} * frame->linesize[0];
      for (int x = 0; x < codes.width; ++x) {
        if (frame->format == AV_PIX_FMT_GRAY8) {
          codes.At(x, y) = glm::u8vec3(row[x]);
          continue;
        }
        std::uint32_t rgb = 0;
        std::memcpy(&rgb, row + 4 * x, sizeof rgb);
        codes.At(x, y) = {rgb >> 16 & 0xffu, rgb >> 8 & 0xffu, rgb & 0xffu};
      }
    }
  }

  void SetUpConversion() {
    const auto format = static_cast<AVPixelFormat>(frame->format);
    to_rgb.reset(
        sws_getCachedContext(to_rgb.release(),
                             frame->width,
                             frame->height,
                             format,
                             frame->width,
                             frame->height,
                             AV_PIX_FMT_RGB24,
                             SWS_BILINEAR | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT | SWS_BITEXACT,
                             nullptr,
                             nullptr,
                             nullptr));
    if (!to_rgb) throw std::runtime_error("a pixel format that cannot be converted");
    int matrix = frame->colorspace;
    if (matrix == AVCOL_SPC_UNSPECIFIED || matrix == AVCOL_SPC_RGB) {
      matrix = frame->height >= kHighDefinitionRows ? AVCOL_SPC_BT709 : AVCOL_SPC_SMPTE170M;
    }
    constexpr int kUnit = 1 << 16;
    sws_setColorspaceDetails(to_rgb.get(),
                             sws_getCoefficients(matrix),
                             frame->color_range == AVCOL_RANGE_JPEG ? 1 : 0,
                             sws_getCoefficients(SWS_CS_DEFAULT),
                             1,
                             0,
                             kUnit,
                             kUnit);
  }

  bool IsDamaged() const {
    return frame->decode_error_flags != 0 || (frame->flags & AV_FRAME_FLAG_CORRUPT) != 0;
  }
};

VideoReader::VideoReader(const std::filesystem::path& file) : impl_(std::make_unique<Impl>()) {
  impl_->file = file;
  impl_->Open();
}

VideoReader::~VideoReader() = default;
VideoReader::VideoReader(VideoReader&&) noexcept = default;
VideoReader& VideoReader::operator=(VideoReader&&) noexcept = default;

std::optional<UtcTime> VideoReader::CreationTime() const {
  const AVDictionaryEntry* entry =
      av_dict_get(impl_->container->metadata, "creation_time", nullptr, 0);
  if (entry == nullptr) return std::nullopt;
  try {
    const UtcTime time = ParseUtcTime(entry->value);
    // Cameras without a clock write the start of their count: 1904, 1970.
    if (time >= std::chrono::sys_days{std::chrono::year{1990} / 1 / 1}) return time;
  } catch (const std::invalid_argument&) {
    // No usable time.
  }
  return std::nullopt;
}

std::optional<tl::expected<VideoPicture, std::string>> VideoReader::Next() {
  const int decoded = impl_->Decode();
  if (decoded == AVERROR_EOF) return std::nullopt;
  if (decoded < 0) return tl::unexpected("damaged picture: " + LibavError(decoded));
  if (impl_->IsDamaged()) return tl::unexpected(std::string("damaged picture"));
  try {
    return VideoPicture{impl_->CodesOfFrame(), impl_->TimeOfFrame()};
  } catch (const std::exception& error) {
    return tl::unexpected(std::string(error.what()));
  }
}

bool VideoReader::Skip() { return impl_->Decode() != AVERROR_EOF; }

}  // namespace pleinair
