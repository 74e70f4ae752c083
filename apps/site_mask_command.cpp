#include "apps/site_mask_command.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <fmt/format.h>

#include "apps/progress.h"
#include "calib/shown_picture.h"
#include "datasets/diffuse_mask.h"
#include "datasets/sequence.h"
#include "scene/image_io.h"
#include "session/moving_things_search.h"

namespace pleinair {
namespace {

// The picture at half of its brightness; red: masked, and the brighter the more often hidden; blue:
// hidden, too seldom to be masked. Both keep a third of the rest.
Rgb8Image Overview(const MovingThingsInSequence& things) {
  Rgb8Image picture = things.shown.codes ? *things.shown.codes : Shown(things.shown.radiance);
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    glm::u8vec3& pixel = picture.pixels[i];
    pixel /= std::uint8_t{2};
    const float hidden = things.found.hidden_share.pixels[i];
    const auto mark = static_cast<std::uint8_t>(95.0f + 160.0f * hidden);
    const bool is_masked = things.found.mask.pixels[i] == 0;
    if (!is_masked && !(hidden > 0.0f)) continue;
    pixel = is_masked ? glm::u8vec3(mark, pixel.y / 3, pixel.z / 3)
                      : glm::u8vec3(pixel.x / 3, pixel.y / 3, mark);
  }
  return picture;
}

double Percent(std::int64_t part, std::int64_t all) {
  return all > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(all) : 0.0;
}

}  // namespace

std::string RunSiteMask(const SiteMaskOptions& options) {
  const MovingThingsInSequence things =
      FindMovingThings(options.session, options.frames, options.moving, ProgressOnStandardError());
  std::int64_t pixels = 0;
  std::int64_t masked = 0;
  std::string table;
  for (const MovingThingsFound::Region& region : things.found.regions) {
    pixels += region.pixels;
    masked += region.masked;
    table += fmt::format("{:7.2f} %  of {:7} px  {}\n",
                         Percent(region.masked, region.pixels),
                         region.pixels,
                         region.name);
  }
  std::string report = fmt::format(
      "{} frames used, {} left out{}\n"
      "usual change of a surface from frame to frame: {:.1f} %\n"
      "masked, of the pixels that may be sampled:\n{}{:7.2f} %  of {:7} px  all\n",
      things.found.frames,
      things.left_out,
      things.left_out > 0 ? " (first: " + things.why_left_out + ")" : "",
      100.0 * things.found.typical_change,
      table,
      Percent(masked, pixels),
      pixels);
  if (!options.out.empty()) {
    WritePng(options.out, things.found.mask);
    report += "mask: " + options.out.string() + "\n";
  }
  if (!options.overview.empty()) {
    WritePng(options.overview, Overview(things));
    report += "overview: " + options.overview.string() + "\n";
  }
  if (options.write) {
    const Sequence sequence = ReadSequence(options.session.sequence, SequencePoses::kMayBeAbsent);
    report += "written: " + SaveDiffuseMask(sequence, things.found.mask).string() + "\n";
  }
  return report;
}

}  // namespace pleinair
