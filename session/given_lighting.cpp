#include "session/given_lighting.h"

#include <stdexcept>

#include <fmt/format.h>

#include "datasets/lighting_record.h"
#include "sunmodel/time_text.h"

namespace pleinair {

std::map<int, GivenLight> ReadGivenLighting(const std::filesystem::path& file) {
  std::map<int, GivenLight> by_frame;
  for (const LightingRecord& record : ReadLightingRecords(file)) {
    if (record.error) continue;
    const auto refuse = [&](const std::string& why) {
      throw std::runtime_error(fmt::format("{}: frame {}: {}", file.string(), record.frame, why));
    };
    if (!record.light.sun_irradiance_rgb) refuse("sun_irradiance_rgb: expected three numbers");
    if (!record.light.sky_irradiance_rgb) refuse("sky_irradiance_rgb: expected three numbers");
    GivenLight light;
    light.time = record.time;
    light.sun_direction_enu = record.light.sun_direction_enu;
    light.sun_irradiance_rgb = *record.light.sun_irradiance_rgb;
    light.sky_irradiance_rgb = *record.light.sky_irradiance_rgb;
    light.sky_image = record.sky_image;
    // An image overrides the shape beside it, which a run derived from it.
    if (!light.sky_image) light.sky_shares = record.sky_shape;
    light.sun_observable = record.sun_observable.value_or(false);
    try {
      light.Validate();
    } catch (const std::invalid_argument& error) {
      refuse(error.what());
    }
    if (light.sky_image && !std::filesystem::is_regular_file(*light.sky_image)) {
      refuse("sky_image: " + light.sky_image->string() + ": expected a picture there");
    }
    by_frame.emplace(record.frame, std::move(light));
  }
  if (by_frame.empty()) {
    throw std::runtime_error(file.string() + ": no frame has light: expected one at least");
  }
  return by_frame;
}

void RequireLightingOf(const Sequence& sequence, const std::filesystem::path& file) {
  for (const auto& [frame, light] : ReadGivenLighting(file)) {
    const auto index = static_cast<std::size_t>(frame);
    if (index >= sequence.frames.size()) continue;
    const std::string fault = FaultOfTime(light.time, sequence.frames[index].time);
    if (fault.empty()) continue;
    throw std::runtime_error(fmt::format("{}: frame {}: {}", file.string(), frame, fault));
  }
}

}  // namespace pleinair
