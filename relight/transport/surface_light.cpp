#include "relight/transport/surface_light.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>

namespace pleinair {

namespace {

// Of each side's edges.
std::vector<std::uint16_t> PartsOf(const PatchScene& scene,
                                   const GatheredRays& face_rays,
                                   const SurfaceLightOptions& options) {
  // What a ray meets within its own patch's reach is no nearer than a part of that: a patch's rays
  // start all over it.
  constexpr float kNearestShare = 0.25f;
  options.Validate();
  std::vector<glm::vec3> middle_m(scene.PatchCount());
  tbb::parallel_for(std::size_t{0}, middle_m.size(), [&](std::size_t patch) {
    middle_m[patch] = scene.PatchMiddleM(patch);
  });
  std::vector<double> nearness_per_m(scene.FaceCount(), 0.0);
  tbb::parallel_for(std::size_t{0}, scene.FaceCount(), [&](std::size_t face) {
    const float nearest_m = kNearestShare * scene.LongestEdgeM(face / 2);
    for (const GatheredRays::FaceShare& seen : face_rays.FacesOf(face)) {
      const glm::vec3& seen_m = middle_m[static_cast<std::size_t>(seen.face) / 2];
      nearness_per_m[face] +=
          seen.share / std::max(glm::distance(middle_m[face / 2], seen_m), nearest_m);
    }
  });
  std::vector<std::uint16_t> parts(scene.SideCount(), 1);
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t side) {
    const auto face = static_cast<std::size_t>(scene.FaceOfSide(static_cast<std::int32_t>(side)));
    const double wanted =
        std::ceil(scene.LongestEdgeM(face / 2) * nearness_per_m[face] / options.spacing);
    parts[side] = static_cast<std::uint16_t>(
        std::clamp(wanted, 1.0, static_cast<double>(options.most_parts)));
  });
  return parts;
}

GatherOptions WithRays(int rays_per_receiver, GatherOptions gather) {
  gather.rays_per_receiver = rays_per_receiver;
  gather.from_exposed_parts = false;
  gather.receivers_per_set = 1;
  return gather;
}

}  // namespace

void SurfaceLightOptions::Validate() const {
  if (!(spacing > 0.0)) {
    throw std::invalid_argument("surfaces.spacing is " + std::to_string(spacing) +
                                ": expected more than 0");
  }
  if (most_parts < 1 || most_parts > 64) {
    throw std::invalid_argument("surfaces.most_parts is " + std::to_string(most_parts) +
                                ": expected 1 to 64");
  }
}

SurfaceLight::SurfaceLight(const PatchScene& scene,
                           const GatheredRays& face_rays,
                           const SurfaceLightOptions& options,
                           const GatherOptions& gather)
    : scene_(scene),
      gather_(WithRays(options.rays_per_receiver, gather)),
      lattice_(scene, PartsOf(scene, face_rays, options)),
      is_shown_(scene.SideCount(), 0),
      is_gathered_(lattice_.Receivers().size(), 0) {
  gather_.Validate();
}

void SurfaceLight::Show(const Image<std::int32_t>& side) {
  std::atomic<bool> any_is_new = false;
  tbb::parallel_for(0, side.height, [&](int y) {
    const auto begin = side.pixels.begin() + static_cast<std::ptrdiff_t>(side.Index(0, y));
    if (std::any_of(begin, begin + side.width, [&](std::int32_t shown) {
          return shown != PatchScene::kSky && is_shown_[static_cast<std::size_t>(shown)] == 0;
        })) {
      any_is_new = true;
    }
  });
  if (!any_is_new) return;
  Batch batch;
  for (const std::int32_t shown : side.pixels) {
    if (shown == PatchScene::kSky || is_shown_[static_cast<std::size_t>(shown)] != 0) continue;
    is_shown_[static_cast<std::size_t>(shown)] = 1;
    for (const std::uint32_t receiver : lattice_.ReceiversOf(static_cast<std::size_t>(shown))) {
      if (std::exchange(is_gathered_[receiver], std::uint8_t{1}) == 0) {
        batch.receivers.push_back(receiver);
      }
    }
  }
  if (batch.receivers.empty()) return;
  std::vector<Receiver> receivers;
  receivers.reserve(batch.receivers.size());
  for (const std::uint32_t receiver : batch.receivers) {
    receivers.push_back(lattice_.Receivers()[receiver]);
  }
  batch.rays = GatheredRays(scene_, receivers, batch.receivers, gather_);
  std::vector<std::size_t> all(lights_.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  Evaluate(batch, all);
  batches_.push_back(std::move(batch));
}

void SurfaceLight::SetLights(std::vector<IndexedLight> lights) {
  std::vector<std::size_t> indices;
  for (IndexedLight& light : lights) {
    indices.push_back(light.index);
    if (light.index >= lights_.size()) lights_.resize(light.index + 1);
    lights_[light.index] = {std::move(light.sky), std::move(light.face_radiosity)};
  }
  if (lights_.size() > stride_) {
    std::vector<glm::vec3> wider(ReceiverCount() * lights_.size(), glm::vec3(0.0f));
    for (std::size_t i = 0; i < ReceiverCount(); ++i) {
      for (std::size_t k = 0; k < stride_; ++k) {
        wider[i * lights_.size() + k] = values_[i * stride_ + k];
      }
    }
    values_ = std::move(wider);
    stride_ = lights_.size();
  }
  for (const Batch& batch : batches_) Evaluate(batch, indices);
}

void SurfaceLight::Evaluate(const Batch& batch, std::span<const std::size_t> lights) {
  const std::size_t count = lights.size();
  if (count == 0) return;
  std::vector<const SkyShape*> skies;
  std::vector<std::size_t> with_sky;  // Places in `lights`.
  std::vector<glm::vec3> radiosity(scene_.FaceCount() * count, glm::vec3(0.0f));
  for (std::size_t k = 0; k < count; ++k) {
    const Light& light = lights_[lights[k]];
    for (std::size_t face = 0; face < light.face_radiosity.size(); ++face) {
      radiosity[face * count + k] = light.face_radiosity[face];
    }
    if (!light.sky) continue;
    skies.push_back(light.sky.get());
    with_sky.push_back(k);
  }
  const std::vector<glm::vec3> bounced = batch.rays.FromFaces(radiosity, count);
  const std::vector<std::vector<glm::vec3>> direct = batch.rays.FromSkies(skies);
  for (std::size_t i = 0; i < batch.receivers.size(); ++i) {
    for (std::size_t k = 0; k < count; ++k) {
      ValueAt(batch.receivers[i], lights[k]) = bounced[i * count + k];
    }
    for (std::size_t sky = 0; sky < with_sky.size(); ++sky) {
      ValueAt(batch.receivers[i], lights[with_sky[sky]]) += direct[sky][i];
    }
  }
}

void SurfaceLight::LookUp(const PlanarBlocks& planar,
                          const Image<std::int32_t>& side,
                          const Image<glm::vec3>& position_m,
                          std::span<const std::size_t> light_of_image,
                          std::span<Image<glm::vec3>* const> at_pixels) const {
  const PixelBlocks& blocks = planar.blocks;
  for (Image<glm::vec3>* image : at_pixels) SizeFor(blocks, *image);
  const auto blank = [&](std::size_t pixel) {
    for (Image<glm::vec3>* image : at_pixels) image->pixels[pixel] = glm::vec3(0.0f);
  };
  const auto look_up = [&](std::size_t pixel, FaceLattice::LastSide& last_side) {
    const std::int32_t shown = side.pixels[pixel];
    if (shown == PatchScene::kSky) return blank(pixel);
    if (is_shown_[static_cast<std::size_t>(shown)] == 0) {
      throw std::logic_error("SurfaceLight: a side is looked up that was not shown");
    }
    const auto around = last_side.Around(static_cast<std::size_t>(shown), position_m.pixels[pixel]);
    for (std::size_t image = 0; image < at_pixels.size(); ++image) {
      glm::vec3 sum(0.0f);
      for (const FaceLattice::Weighted& at : around) {
        sum += at.weight * values_[at.receiver * stride_ + light_of_image[image]];
      }
      at_pixels[image]->pixels[pixel] = sum;
    }
  };
  ForBlocks(
      blocks,
      [&](int y, std::span<const std::uint8_t> wanted) {
        FaceLattice::LastSide last_side(lattice_, scene_);
        for (int x = 0; x < blocks.Width(); ++x) {
          if (wanted[static_cast<std::size_t>(x)] != 0) look_up(side.Index(x, y), last_side);
        }
      },
      [&](int column, int row, const PixelBlock& block) {
        if (planar.is_planar[blocks.Index(column, row)] == 0) return false;
        const std::array<std::size_t, 4> corners = blocks.Corners(block);
        for (Image<glm::vec3>* image : at_pixels) {
          const PixelBlock::Blend<glm::vec3> blend(block,
                                                   {image->pixels[corners[0]],
                                                    image->pixels[corners[1]],
                                                    image->pixels[corners[2]],
                                                    image->pixels[corners[3]]});
          blend.FillBetween(*image);
        }
        return true;
      },
      blank);
}

}  // namespace pleinair
