// FFmpeg's objects with owners.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "datasets/video/internal/libav_functions.h"

namespace pleinair {

struct LibavDelete {
  void operator()(AVCodecContext* context) const { avcodec_free_context(&context); }
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
  void operator()(SwsContext* context) const { sws_freeContext(context); }
};
template <typename Object>
using LibavPointer = std::unique_ptr<Object, LibavDelete>;

inline std::string LibavError(int error) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(error, text, sizeof text);
  return text;
}

// A name may hold a colon, as times do: that is no protocol.
inline std::string LibavUrl(const std::filesystem::path& file) { return "file:" + file.string(); }

// The container's tag of FFV1 whose slices all have checksums.
inline constexpr const char* kHasSliceChecksums = "SLICE_CHECKSUMS";

// FFmpeg writes to the error stream by itself.
inline void SilenceLibav() { av_log_set_level(AV_LOG_QUIET); }

}  // namespace pleinair
