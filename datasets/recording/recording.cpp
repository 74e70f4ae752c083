#include "datasets/recording/recording.h"

#include <stdexcept>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "datasets/camera/live_frame_source.h"
#include "datasets/diffuse_mask.h"
#include "datasets/internal/sampling_mask.h"
#include "datasets/internal/sequence_folder.h"
#include "datasets/internal/sequence_json.h"
#include "datasets/internal/site_frames.h"
#include "datasets/recording/site_files.h"
#include "scene/image_io.h"
#include "scene/whole_file.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

namespace fs = std::filesystem;

constexpr double kMegabyte = 1e6;
constexpr const char* kFrames = "frames.jsonl";

RecordingOptions WithFreeBytes(RecordingOptions options) {
  if (!options.free_bytes) {
    options.free_bytes = [folder = fs::absolute(options.folder)] {
      fs::path at = folder;  // May not be there yet.
      while (!fs::exists(at)) at = at.parent_path();
      return fs::space(at).available;
    };
  }
  return options;
}

[[noreturn]] void RefuseForSpace(const fs::path& folder, std::uint64_t free, std::uint64_t needed) {
  throw std::runtime_error(fmt::format("{}: expected {:.0f} MB of free space, found {:.0f} MB",
                                       folder.string(),
                                       static_cast<double>(needed) / kMegabyte,
                                       static_cast<double>(free) / kMegabyte));
}

void RequireNoFiles(const fs::path& folder) {
  if (!fs::exists(folder) || fs::is_empty(folder)) return;
  RefuseFile(folder, "expected a new folder, or an empty one");
}

// The site with a camera that takes pictures of this layout.
Sequence AtLayout(Sequence site, const PictureLayout& layout) {
  site.intrinsics = ScaledTo(site.intrinsics, layout.width_px, layout.height_px);
  return site;
}

// A mask over the first picture replaces its copy: it has the pictures' size.
void ScaleMask(const Sequence& site, const PictureLayout& layout, const fs::path& folder) {
  const CameraIntrinsics& camera = site.intrinsics;
  if (camera.width_px == layout.width_px && camera.height_px == layout.height_px) return;
  const auto mask = ReadDiffuseMask(site);
  if (!mask || mask->is_over_map) return;
  const fs::path copy = folder / *site.diffuse_mask;
  fs::remove(copy);
  WritePng(copy, ScaledMask(mask->image, layout.width_px, layout.height_px));
}

// For the site's files and the pictures.
void RequireSpace(const fs::path& site,
                  const std::vector<fs::path>& files,
                  const PictureLayout& layout,
                  const RecordingOptions& options) {
  const double pictures = options.expected_pictures.value_or(1.0);
  const std::uint64_t needed =
      SizeOf(site, files) + options.keep_free_bytes +
      static_cast<std::uint64_t>(pictures * EstimatedBytes(layout, options.store));
  const std::uint64_t free = options.free_bytes();
  if (free < needed) RefuseForSpace(options.folder, free, needed);
}

void CopyFiles(const fs::path& from, const std::vector<fs::path>& files, const fs::path& to) {
  for (const fs::path& file : files) {
    fs::create_directories((to / file).parent_path());
    fs::copy_file(from / file, to / file);
  }
}

}  // namespace

Recording::Recording(const Sequence& site,
                     const PictureLayout& layout,
                     const RecordingOptions& options)
    : options_(WithFreeBytes(options)), layout_(layout) {
  Sequence sequence = AtLayout(site, layout);
  RequireNoFiles(options.folder);
  const std::vector<fs::path> files = SiteFiles(site.folder, options.folder);
  RequireSpace(site.folder, files, layout, options_);
  MakeFolder(options.folder);
  pictures_ = MakePictureFiles(options.store, layout, options.folder);
  CopyFiles(site.folder, files, options.folder);
  ScaleMask(site, layout, options.folder);

  frames_ = std::make_unique<LineFile>(options.folder / kFrames);
  events_ = std::make_unique<LineFile>(options.folder / "events.jsonl");
  sequence.name = fs::weakly_canonical(options.folder).filename().string();
  sequence.frames.clear();
  nlohmann::ordered_json json = JsonOf(sequence);
  json["frames"] = kFrames;
  json["note_frames"] =
      "f_number is 1 where the camera's aperture is fixed and unknown; iso is 100 times the gain, "
      "which is 1 at that of the lock where the driver states no unit";
  // The last of all: a folder without it is no recording yet.
  WriteSequenceJson(json, options.folder);
  Sync();
}

tl::expected<std::uint64_t, std::string> Recording::Add(const CameraFrame& frame) {
  const CapturedBuffer& buffer = frame.buffer;
  if (buffer.is_damaged) return tl::unexpected(std::string("the driver reports damage"));
  if (buffer.layout.format != layout_.format || buffer.layout.width_px != layout_.width_px ||
      buffer.layout.height_px != layout_.height_px) {
    return tl::unexpected(fmt::format("expected {} {}x{}, found {} {}x{}",
                                      NameOf(layout_.format),
                                      layout_.width_px,
                                      layout_.height_px,
                                      NameOf(buffer.layout.format),
                                      buffer.layout.width_px,
                                      buffer.layout.height_px));
  }
  const std::uint64_t free = FreeBytes();
  if (free < options_.keep_free_bytes) {
    RefuseForSpace(options_.folder, free, options_.keep_free_bytes);
  }
  FrameEntry entry;
  entry.time = frame.time;
  entry.camera_from_world = frame.camera_from_world;
  SetExposure(buffer.exposure, entry);
  auto bytes = pictures_->Add(frame, entry);
  if (bytes) frames_->Add(JsonOf(entry).dump());
  return bytes;
}

void Recording::AddEvents(std::span<const Event> events) {
  for (const Event& event : events) events_->Add(LineOf(event));
}

void Recording::Finish() { pictures_->Finish(); }

double EstimatedBytes(const PictureLayout& layout, PictureStore store) {
  const double pixels = static_cast<double>(layout.width_px) * layout.height_px;
  const PixelCoding coding = layout.format.coding;
  if (store == PictureStore::kH264) return 0.05 * pixels;
  if (store == PictureStore::kFfv1) return (coding == PixelCoding::kGrey ? 0.6 : 1.5) * pixels;
  if (coding == PixelCoding::kMjpeg) return 0.3 * pixels;
  if (coding == PixelCoding::kBayer)
    return static_cast<double>(layout.stride_bytes) * layout.height_px;
  return (coding == PixelCoding::kGrey ? 0.7 : 2.0) * pixels;
}

std::string LineOf(const Event& event) {
  nlohmann::ordered_json json = {
      {"time_utc", FormatUtcTime(event.time)}, {"event", NameOf(event.kind)}, {"text", event.text}};
  if (event.count != 1) json["count"] = event.count;
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace pleinair
