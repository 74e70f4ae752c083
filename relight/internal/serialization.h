// Prepared parts as bytes, through cereal.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include <cereal/archives/binary.hpp>
#include <cereal/types/optional.hpp>
#include <cereal/types/string.hpp>
#include <cereal/types/vector.hpp>

#include "relight/survey/survey.h"
#include "relight/transport/surface_gather.h"
#include "relight/transport/transport.h"
#include "scene/state_id.h"
#include "scene/surface_view.h"

namespace pleinair::internal {

// Plain values as one block: cereal's own form would visit each float.
template <class Archive, class Value>
void ArchiveBlock(Archive& archive, std::vector<Value>& values) {
  static_assert(std::is_trivially_copyable_v<Value>);
  std::uint64_t count = values.size();
  archive(count);
  if constexpr (Archive::is_loading::value) values.resize(count);
  archive(cereal::binary_data(values.data(), count * sizeof(Value)));
}

template <class Archive, class Value>
void ArchivePlain(Archive& archive, Value& value) {
  static_assert(std::is_trivially_copyable_v<Value>);
  archive(cereal::binary_data(&value, sizeof(Value)));
}

template <class Archive, class Pixel>
void ArchiveImage(Archive& archive, Image<Pixel>& image) {
  archive(image.width, image.height);
  ArchiveBlock(archive, image.pixels);
}

template <class Archive>
void ArchiveView(Archive& archive, SurfaceView& view) {
  archive(view.region_names);
  ArchiveImage(archive, view.region);
  ArchiveImage(archive, view.position_world_m);
  ArchiveImage(archive, view.normal_world);
  ArchiveImage(archive, view.albedo_rgb);
  ArchiveImage(archive, view.albedo_measured);
  ArchiveImage(archive, view.may_be_sampled);
  std::uint64_t skies = view.sky_response.size();
  archive(skies);
  if constexpr (Archive::is_loading::value) view.sky_response.resize(skies);
  for (Image<glm::vec3>& sky : view.sky_response) ArchiveImage(archive, sky);
  ArchiveImage(archive, view.sun_visibility);
  ArchiveImage(archive, view.sun_bounce);
  ArchiveImage(archive, view.edge_distance_px);
  ArchiveImage(archive, view.footprint_radius_px);
  ArchivePlain(archive, view.sun_direction_enu);
  if constexpr (Archive::is_loading::value) {
    view.geometry_id = StateId::Next();
    view.sky_id = StateId::Next();
    view.sun_id = StateId::Next();
  }
}

template <class Archive>
void ArchiveSurvey(Archive& archive, Survey& survey) {
  ArchivePlain(archive, survey.position_m);
  SurveyLight& light = survey.light;
  ArchivePlain(archive, light.sun_direction_enu);
  ArchivePlain(archive, light.sun_irradiance_rgb);
  ArchivePlain(archive, light.sun_irradiance_stddev_rgb);
  ArchivePlain(archive, light.sky_irradiance_rgb);
  ArchivePlain(archive, light.sun_origin);
  ArchivePlain(archive, light.albedo_stddev_rgb);
  ArchivePlain(archive, light.clear_sky_beam_rgb);
  archive(light.sun_clipped, light.sun_hidden, light.aerosol_optical_depth_500nm, light.notes);
  ArchiveImage(archive, light.sky_radiance);
  ArchiveImage(archive, survey.unmodelled_shade);
  ArchiveBlock(archive, survey.skyline.hidden);
  ArchiveBlock(archive, survey.skyline.reflected);
  ArchiveImage(archive, survey.skyline.irradiance_of_hidden);
  ArchiveView(archive, survey.view);
  // Only the loading side may write through the pointer: it has just made what it points to.
  if constexpr (Archive::is_loading::value) {
    const auto gather = std::make_shared<SurfaceGather>();
    archive(*gather);
    survey.gather = gather;
  } else {
    archive(*survey.gather);
  }
}

}  // namespace pleinair::internal

namespace pleinair {

template <class Archive>
void GatheredRays::serialize(Archive& archive) {
  internal::ArchiveBlock(archive, face_begin_);
  internal::ArchiveBlock(archive, face_);
  internal::ArchiveBlock(archive, face_share_);
  internal::ArchiveBlock(archive, sky_begin_);
  internal::ArchiveBlock(archive, sky_direction_);
  internal::ArchiveBlock(archive, ray_count_);
  internal::ArchiveBlock(archive, hidden_scale_);
  archive(rays_per_receiver_);
  if constexpr (Archive::is_loading::value) DescribeSky();
}

template <class Archive>
void PatchTransport::serialize(Archive& archive) {
  internal::ArchiveBlock(archive, face_points_.begin);
  internal::ArchiveBlock(archive, face_points_.position_m);
  internal::ArchiveBlock(archive, face_points_.whole);
  archive(face_rays_);
}

template <class Archive>
void SurfaceGather::serialize(Archive& archive) {
  // Only the loading side may write through the pointer: it has just made what it points to.
  if constexpr (Archive::is_loading::value) {
    const auto rays = std::make_shared<GatheredRays>();
    archive(*rays);
    rays_ = rays;
  } else {
    archive(*rays_);
  }
  internal::ArchiveBlock(archive, entry_begin_);
  internal::ArchiveBlock(archive, entries_);
}

}  // namespace pleinair
