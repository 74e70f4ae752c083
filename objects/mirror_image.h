// Mirror images on glossy virtual objects: sky, real surfaces and objects as seen from the very
// points that mirror them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "objects/object_view.h"
#include "relight/survey/survey_look_up.h"
#include "relight/transport/patch_scene.h"
#include "scene/lighting.h"
#include "scene/mirrored_light.h"
#include "scene/sky_shape.h"
#include "scene/surface_view.h"

namespace pleinair {

struct MirrorImageOptions {
  // Over a pixel's square and the lobe around the mirror direction. Converged: many.
  int rays_per_pixel = 32;
  // Rays from a mirrored real surface, for what objects hide from it. Converged: many; 0: none.
  int rays_per_place = 8;
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// What is known of real surfaces besides their geometry. May be null; used during construction
// only.
struct RealAppearance {
  const SurveyLookUp* survey = nullptr;     // Else real surfaces have their face's albedo.
  const SurfaceView* in_picture = nullptr;  // Where the camera sees them.
};

// Light in the scene under a unit of one basis light, for MirrorImage::Fold.
struct MirroredBasis {
  const SkyShape* sky = nullptr;  // Null for the sun.
  // Radiosity of the faces; of the real ones without the objects.
  std::span<const glm::vec3> real_radiosity;
  std::span<const glm::vec3> object_radiosity;
  // For the sun: the irradiance of the real faces by its disc. Else empty.
  std::span<const glm::vec3> real_direct;
  DirectionalLight sun;
};

// Set up once per view and pose. Rays leave the glossy surfaces in a pixel's square along half
// vectors of the visible GGX normals (Heitz 2018, "Sampling the GGX distribution of visible
// normals"); the hit of each is stored. A real surface has the survey's albedo at the very place.
// It is in the sun where a ray from there reaches it past real and virtual casters, unless the
// picture shows shade there that the mesh does not cast. It lacks the light that objects hide from
// it. The disc itself is not mirrored: the renderer's glint is analytic. Other mirrors are shown as
// if they were diffuse.
//
// Threads  The result does not depend on their number.
class MirrorImage {
 public:
  // Mirrors nothing.
  MirrorImage() = default;
  // Keeps no reference.
  MirrorImage(const PatchScene& real,
              const PatchScene& objects,
              const ObjectView& view,
              const RealAppearance& appearance = {},
              const MirrorImageOptions& options = {});

  // Whether any glossy surface is in view.
  bool Empty() const { return entries_.empty(); }

  // Computes the response to a unit of basis light `light`; 0 is the sun, 1 + k sky shape k. The
  // scenes are those of construction.
  // Throws std::invalid_argument where a number of faces is another.
  void Fold(std::size_t light,
            const MirroredBasis& basis,
            const PatchScene& real,
            const PatchScene& objects);

  // The pixels of the camera's picture that show a mirrored place in the sun, as far as the meshes
  // say; known once the sun was folded. Each once.
  std::span<const std::int32_t> SunlitPixels() const { return sunlit_pixels_; }

  // The image under `lighting`, which has the sky components that were folded; `image` keeps its
  // memory. Throws std::invalid_argument for another number of components.
  //
  // Real surfaces have no sun where `is_in_shade`, one value for each of SunlitPixels(), is not 0;
  // empty: they have what the meshes say. Throws std::invalid_argument for another number of
  // values.
  void Evaluate(const Lighting& lighting,
                std::span<const std::uint8_t> is_in_shade,
                MirroredLight& image) const;

 private:
  struct Entry {
    glm::vec3 weight{0.0f};     // Reflectance over the number of rays.
    glm::vec3 direction{0.0f};  // The ray's direction.
    std::int32_t place = kSky;  // In places_, or kSky, or -2 - object face.
  };
  static constexpr std::int32_t kSky = -1;
  // A place on a real surface that a ray meets.
  struct Place {
    glm::vec3 start_m{0.0f};  // Off the surface.
    std::int32_t face = 0;
    glm::vec3 tint{1.0f};               // Albedo there over the face's.
    std::optional<std::int32_t> pixel;  // Its pixel in the camera's picture.
    std::uint32_t first_hider = 0;
    std::uint32_t hider_count = 0;  // Object faces, of rays_per_place_ rays.
  };

  // A basis light on real surfaces and objects; for the sun, with directions to points of its disc.
  struct LitScene {
    const MirroredBasis& basis;
    const PatchScene& real;
    const PatchScene& objects;
    std::vector<glm::vec3> to_sun;
  };
  glm::vec3 RadiosityAt(const Place& place, const LitScene& lit) const;
  // The part by the disc itself; `index` chooses its point.
  glm::vec3 DirectRadiosityAt(const Place& place, std::size_t index, const LitScene& lit) const;
  void NumberSunlitPixels();

  // Sun that a pixel mirrors from one place that the camera sees.
  struct SunlitPlace {
    std::uint32_t pixel = 0;      // Its pixel in the mirror image.
    std::int32_t in_picture = 0;  // Its number among sunlit_pixels_.
    glm::vec3 response{0.0f};
  };

  int x_px_ = 0;
  int y_px_ = 0;
  int width_px_ = 0;
  int height_px_ = 0;
  int rays_per_place_ = 0;
  std::vector<std::uint32_t> first_entry_;  // Per pixel, entries [begin, next begin).
  std::vector<Entry> entries_;
  std::vector<Place> places_;
  std::vector<std::int32_t> hiders_;
  std::vector<std::vector<glm::vec3>> responses_;  // Per basis light and pixel.
  std::vector<SunlitPlace> sunlit_places_;
  std::vector<std::int32_t> sunlit_pixels_;
};

}  // namespace pleinair
