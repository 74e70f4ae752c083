// Light on the surfaces of a scene, kept where it was gathered: it stays while the camera moves.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/transport/face_lattice.h"
#include "relight/transport/patch_scene.h"
#include "relight/transport/pixel_blocks.h"
#include "relight/transport/transport.h"
#include "scene/image.h"
#include "scene/sky_shape.h"

namespace pleinair {

struct SurfaceLightOptions {
  // Distance of receivers over that of the surfaces around them, a harmonic mean over a face's rays
  // (Ward, Rubinstein and Clear, "A ray tracing solution for diffuse interreflection", 1988). So
  // they are close where walls meet and where something stands.
  double spacing = 0.25;
  int most_parts = 4;  // Most parts of a face's edge; bounds memory.
  // Kept for all views, so more than a picture's own receivers cast.
  int rays_per_receiver = 512;
  // Throws std::invalid_argument naming field and value.
  void Validate() const;
};

// Irradiance under unit lights at the receivers of a lattice over the triangles. Receivers gather
// when a view first shows a side that has them, so that memory and time are for what has been seen;
// what they gather does not depend on when. A pixel blends those of its side.
//
// One thread at a time.
class SurfaceLight {
 public:
  // Keeps a reference to `scene`, whose faces' rays are `face_rays`. Rays are cast as `gather`
  // says, but for their number.
  SurfaceLight(const PatchScene& scene,
               const GatheredRays& face_rays,
               const SurfaceLightOptions& options,
               const GatherOptions& gather);

  // Gathers for the sides of triangles in `side` that have not been shown yet.
  // Shape  the side that each pixel shows, PatchScene::kSky where none.
  void Show(const Image<std::int32_t>& side);

  // Light `index` is that of a sky (null: none) and of faces with these radiosities.
  struct IndexedLight {
    std::size_t index = 0;
    std::shared_ptr<const SkyShape> sky;
    std::vector<glm::vec3> face_radiosity;
  };
  // Several at once: the rays are read only once.
  void SetLights(std::vector<IndexedLight> lights);
  void SetLight(std::size_t light,
                std::shared_ptr<const SkyShape> sky,
                std::vector<glm::vec3> face_radiosity) {
    SetLights({{light, std::move(sky), std::move(face_radiosity)}});
  }

  // Irradiance at the points that pixels show, zero where they show none; within planar blocks it
  // is blended between the corners. Throws std::logic_error for a side that has not been shown.
  // Keeps the images' memory.
  // Shape  light_of_image: which light each of `at_pixels` is of.
  void LookUp(const PlanarBlocks& planar,
              const Image<std::int32_t>& side,
              const Image<glm::vec3>& position_m,
              std::span<const std::size_t> light_of_image,
              std::span<Image<glm::vec3>* const> at_pixels) const;

  std::size_t ReceiverCount() const { return lattice_.Receivers().size(); }

 private:
  struct Light {
    std::shared_ptr<const SkyShape> sky;
    std::vector<glm::vec3> face_radiosity;
  };
  // What one view was the first to show.
  struct Batch {
    std::vector<std::uint32_t> receivers;
    GatheredRays rays;
  };

  glm::vec3& ValueAt(std::uint32_t receiver, std::size_t light) {
    return values_[receiver * stride_ + light];
  }
  void Evaluate(const Batch& batch, std::span<const std::size_t> lights);

  const PatchScene& scene_;
  GatherOptions gather_;
  FaceLattice lattice_;
  std::vector<std::uint8_t> is_shown_;     // Per side.
  std::vector<std::uint8_t> is_gathered_;  // Per receiver.
  std::vector<Batch> batches_;
  std::vector<Light> lights_;
  std::size_t stride_ = 0;         // Lights that there is room for.
  std::vector<glm::vec3> values_;  // [receiver * stride_ + light].
};

}  // namespace pleinair
