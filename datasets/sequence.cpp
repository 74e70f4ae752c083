#include "datasets/sequence.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace pleinair {

std::optional<double> FrameEntry::EffectiveExposure() const {
  if (exposure) return exposure;
  if (exposure_s && iso && f_number) return *exposure_s * *iso / (*f_number * *f_number);
  return std::nullopt;
}

std::string Sequence::NameOrFolder() const {
  return name.empty() ? folder.filename().string() : name;
}

bool Sequence::HasPictures() const {
  return std::any_of(frames.begin(), frames.end(), [](const FrameEntry& frame) {
    return frame.image || frame.image_ldr || frame.raw;
  });
}

Camera Sequence::CameraOfFrame(std::size_t frame) const {
  const FrameEntry& entry = frames.at(frame);
  if (entry.camera_from_world) return {intrinsics, *entry.camera_from_world};
  if (camera_from_world) return {intrinsics, *camera_from_world};
  throw std::invalid_argument("frame " + std::to_string(frame) + " has no camera_from_world");
}

std::optional<glm::dvec3> Sequence::StatedSunDirectionEnu(std::size_t frame) const {
  const FrameEntry& entry = frames.at(frame);
  return entry.sun_direction_enu ? entry.sun_direction_enu : StatedSunDirectionEnu();
}

std::optional<glm::dvec3> Sequence::StatedSunDirectionEnu() const {
  if (site) return std::nullopt;
  return environment ? environment->sun_direction_enu : sun_direction_enu;
}

std::optional<Weather> Sequence::WeatherOfFrame(std::size_t frame) const {
  const FrameEntry& entry = frames.at(frame);
  return entry.weather ? entry.weather : weather;
}

}  // namespace pleinair
