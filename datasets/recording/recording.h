// A sequence that is written while its pictures come.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include <tl/expected.hpp>

#include "datasets/camera/camera_capture.h"
#include "datasets/event.h"
#include "datasets/recording/line_file.h"
#include "datasets/recording/picture_files.h"
#include "datasets/sequence.h"

namespace pleinair {

struct RecordingOptions {
  std::filesystem::path folder;  // New, or empty.
  PictureStore store = PictureStore::kRaw;
  std::uint64_t keep_free_bytes = 200'000'000;  // Of the file system: a recording ends before.
  // That are to fit, as far as their sizes can be estimated.
  std::optional<double> expected_pictures;
  // Of the folder's file system, for programs without privileges; none: as the system says.
  std::function<std::uint64_t()> free_bytes;
};

// A folder that ReadSequence reads from the first picture on, at any moment: sequence.json, the
// site's files, and frames.jsonl, which gets a frame's line when its picture is complete. A process
// that is killed loses no picture that was added; a power cut none that was added before the last
// Sync. There a listed picture may be missing, or damaged: that is its own error when it is played.
// One thread, but for Sync.
class Recording {
 public:
  // `site` as ReadSite gives it, at pictures of this layout: its camera is scaled to them. Copies
  // the site's files (SiteFiles). Throws std::runtime_error, one line: the folder is not empty,
  // space is short, the site's camera has another shape; std::invalid_argument for a video of Bayer
  // pictures.
  Recording(const Sequence& site, const PictureLayout& layout, const RecordingOptions& options);

  // The picture's bytes on disk, or why there is none: damaged, of another layout than the first.
  // Throws std::runtime_error where the disk is full or fails; the recording is complete without
  // this picture then.
  tl::expected<std::uint64_t, std::string> Add(const CameraFrame& frame);
  // To events.jsonl. Throws as Add.
  void AddEvents(std::span<const Event> events);
  // No picture comes any more: ends a video. Throws as Add.
  void Finish();
  // From any thread; takes as long as the disk needs.
  void Sync() const { frames_->Sync(); }

  std::uint64_t FreeBytes() const { return options_.free_bytes(); }

 private:
  RecordingOptions options_;
  PictureLayout layout_;
  std::unique_ptr<PictureFiles> pictures_;
  std::unique_ptr<LineFile> frames_;
  std::unique_ptr<LineFile> events_;
};

// Of a picture on disk: from pictures of courtyards and rooms.
double EstimatedBytes(const PictureLayout& layout, PictureStore store);

// {"time_utc": ..., "event": "frame-dropped", "text": ..., "count": 3}, one line.
std::string LineOf(const Event& event);

}  // namespace pleinair
