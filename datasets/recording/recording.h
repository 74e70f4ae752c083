// Writes a sequence while its pictures arrive.
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

// Set-up of a recording.
struct RecordingOptions {
  std::filesystem::path folder;  // New, or empty.
  PictureStore store = PictureStore::kRaw;
  // Bytes left free on the file system: a recording ends before.
  std::uint64_t keep_free_bytes = 200'000'000;
  // Pictures that must fit, by their estimated sizes.
  std::optional<double> expected_pictures;
  // Free bytes of the folder's file system, for programs without privileges; none: the system's
  // value.
  std::function<std::uint64_t()> free_bytes;
};

// A folder that ReadSequence can read at any moment from the first picture on. It has
// sequence.json, the site's files, and frames.jsonl, which gets a frame's line when its picture is
// complete. A process that is killed loses no added picture; a power cut loses none that was added
// before the last Sync. After a power cut a listed picture may be missing or damaged: that is its
// own error when it is played. One thread, except for Sync.
class Recording {
 public:
  // `site` as ReadSite gives it, at pictures of this layout: its camera is scaled to them. Copies
  // the site's files (SiteFiles). Throws std::runtime_error, one line: the folder is not empty,
  // space is short, the site's camera has another shape; std::invalid_argument for a video of Bayer
  // pictures.
  Recording(const Sequence& site, const PictureLayout& layout, const RecordingOptions& options);

  // Adds a picture. Returns its bytes on disk, or why it was refused: damaged, or of another layout
  // than the first. Throws std::runtime_error where the disk is full or fails; the recording is
  // then complete without this picture.
  tl::expected<std::uint64_t, std::string> Add(const CameraFrame& frame);
  // To events.jsonl. Throws as Add.
  void AddEvents(std::span<const Event> events);
  // Ends the recording, and its video. Throws as Add.
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

// Estimated bytes of a picture on disk: from pictures of courtyards and rooms.
double EstimatedBytes(const PictureLayout& layout, PictureStore store);

// {"time_utc": ..., "event": "frame-dropped", "text": ..., "count": 3}, one line.
std::string LineOf(const Event& event);

}  // namespace pleinair
