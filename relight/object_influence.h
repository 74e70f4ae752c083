// What virtual objects do to the light of real surfaces beside the sun's own shadow: they hide sky
// and real faces that a surface saw, and shine in their place.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "relight/patch_scene.h"
#include "relight/transport.h"
#include "scene/image.h"
#include "scene/irradiance_change.h"
#include "scene/lighting.h"
#include "scene/sky_shape.h"
#include "scene/surface_view.h"

namespace pleinair {

class FaceLattice;

struct ObjectInfluenceOptions {
  // Over each object's bounding sphere, low-discrepancy, where that fills more than 1/16 of a
  // surface's view; fewer in proportion where it fills less, down to an eighth. Converged: as many
  // as wished, up to 65536.
  int rays_per_receiver = 192;
  // On faces alone: how far apart receivers stand at least, as a share of the radius of the nearest
  // object's bounding sphere. Farther off it is a quarter of the distance to the object. Converged:
  // a tenth of that.
  double least_spacing = 0.06;
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// Which parts of the influence are wanted.
struct InfluenceParts {
  bool hidden_light = true;  // Of the sky and of real faces behind the objects.
  bool object_light = true;  // What the objects send instead.
};

// For one view and one pose of the objects: where rays from the real surfaces meet an object, and
// what they met before it stood there,
//   change of irradiance = sum over rays of weight * pi * (L_object - L_behind).
// A ray that meets the real scene first changes nothing, so nothing darkens twice. Light between
// the surfaces that change is left out: real faces shine as without the objects.
//
// Receivers stand where the objects' bounding spheres fill more than 1/1024 of a surface's view:
// under a clear sun, eight times the sky, a white object brings a shaded surface half a code value
// there.
// At pixels  each near an object has its own; farther off, blocks of up to 7 x 7 pixels share one a
//            plane, and pixels blend those around them. For that view alone.
// On faces   on a lattice over the real faces, which pixels blend: they stay while the camera
//            moves, and what changes in the picture is the look-up.
//
// Threads  The result does not depend on their number.
class ObjectInfluence {
 public:
  // Nothing is changed.
  ObjectInfluence() = default;
  // At pixels. The objects are the groups of `objects`. Keeps no reference.
  ObjectInfluence(const PatchScene& real,
                  const PatchScene& objects,
                  const SurfaceView& view,
                  const ObjectInfluenceOptions& options = {});
  // On faces.
  ObjectInfluence(const PatchScene& real,
                  const PatchScene& objects,
                  const ObjectInfluenceOptions& options = {});

  // On faces: what Evaluate is for. `faces` are those of `real`, as of construction, that the
  // pixels show, PatchScene::kSky where none.
  void See(const PatchScene& real, const SurfaceView& view, const Image<std::int32_t>& faces);

  std::size_t ReceiverCount() const { return receivers_.size(); }
  std::vector<Receiver> Receivers() const;

  // Works out the response to a unit of basis light `light`: 0 is the sun, 1 + k the view's sky
  // shape k. `sky` is null for the sun, whose disc is not in it. `view` is that of construction,
  // with its present responses, and not looked at for receivers on faces; radiosities are of the
  // faces of `real` and `objects` per unit of the light. Where it is known by other means what the
  // objects take of the sky's own light at each of Receivers(), `sky` is null and `hidden_sky` says
  // it; else that is empty. Throws  std::invalid_argument where a number of faces or receivers is
  // another, or the view's
  //         size.
  void Fold(std::size_t light,
            const SkyShape* sky,
            const SurfaceView& view,
            std::span<const glm::vec3> real_radiosity,
            std::span<const glm::vec3> object_radiosity,
            std::span<const glm::vec3> hidden_sky = {});

  // The change under `lighting`, which has the sky components that were folded; 0 where it is less
  // than 1/512 of what the surface gets, a quarter of a code value in white. `change` keeps its
  // memory from frame to frame.
  // Throws  std::invalid_argument where `lighting` has other sky components than were folded.
  void Evaluate(const Lighting& lighting,
                const InfluenceParts& parts,
                IrradianceChange& change) const;

 private:
  struct Hit {
    float share = 0.0f;  // Of the receiver's cosine-weighted hemisphere.
    std::int32_t object_face = 0;
    std::int32_t behind = PatchScene::kSky;  // Real face.
    glm::vec3 direction{0.0f};
  };
  struct ReceiverHits {
    std::size_t pixel = 0;  // Where it stands; on faces: without meaning.
    std::size_t face = 0;   // On faces: a face that it stands on.
    Receiver place;
    std::vector<Hit> hits;
  };
  struct Entry {
    std::uint32_t receiver;
    float weight;
  };
  // Pixels of the part of the picture that can change; empty where upper is not above lower.
  struct Extent {
    glm::ivec2 lower{std::numeric_limits<int>::max()};
    glm::ivec2 upper{0};
  };
  struct Response {
    glm::vec3 hidden{0.0f};
    glm::vec3 gained{0.0f};
    glm::vec3 before{0.0f};  // What the surface gets in all.
  };

  void Gather(const PatchScene& real, const PatchScene& objects, int rays_per_receiver);
  glm::vec3 Before(std::size_t light,
                   const ReceiverHits& receiver,
                   const SurfaceView& view,
                   std::span<const glm::vec3> real_radiosity) const;
  // Of a pixel of the part of the picture that can change.
  std::span<const Entry> EntriesOf(int x, int y) const {
    const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_px_) +
                          static_cast<std::size_t>(x);
    return std::span(entries_).subspan(entry_begin_[i], entry_begin_[i + 1] - entry_begin_[i]);
  }
  std::vector<glm::vec3> AtReceivers(const Lighting& lighting, const InfluenceParts& parts) const;
  // Per row of the part of the picture, the first pixel that may change and the one after the last.
  std::vector<std::array<int, 2>> RowsThatChange(std::span<const glm::vec3> at_receivers) const;

  std::size_t real_faces_ = 0;
  std::size_t object_faces_ = 0;
  int picture_width_px_ = 0;
  int picture_height_px_ = 0;
  // The pixels that can change lie in this part of the picture.
  int x_px_ = 0;
  int y_px_ = 0;
  int width_px_ = 0;
  int height_px_ = 0;
  std::vector<std::uint32_t> entry_begin_;  // Per pixel of that part, entries [begin, next begin).
  std::vector<Entry> entries_;
  std::vector<Extent> extents_;  // At pixels, per receiver: of those that have entries of it.
  std::shared_ptr<const FaceLattice> lattice_;  // Null at pixels.
  std::vector<float> is_open_;              // On faces, per receiver: 0 inside an object, else 1.
  std::vector<glm::vec3> face_albedo_rgb_;  // On faces.
  std::vector<ReceiverHits> receivers_;
  std::vector<std::vector<Response>> responses_;  // Per basis light and receiver.
};

}  // namespace pleinair
