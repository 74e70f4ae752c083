// Change by virtual objects of the light of real surfaces, apart from the sun's own shadow: they
// hide sky and real faces that a surface saw, and shine in their place.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/transport/patch_scene.h"
#include "relight/transport/transport.h"
#include "scene/image.h"
#include "scene/irradiance_change.h"
#include "scene/lighting.h"
#include "scene/sky_shape.h"
#include "scene/surface_view.h"

namespace pleinair {

class FaceLattice;
class InfluenceRays;

// Where the light that objects hide from and send to real surfaces is computed.
enum class InfluenceAt {
  kPixels,  // Recomputed for each view.
  kFaces,   // On a lattice over the surfaces, kept while the camera moves.
};

// Influence of objects in motion: with fewer rays and receivers, until they rest.
struct InfluenceInMotionOptions {
  // As in ObjectInfluenceOptions. 0: an object in motion is treated as one at rest.
  int rays_per_receiver = 32;
  double least_share = 1.0 / 128.0;
  double coarseness = 2.0;
  // At rest: for how many receivers rays are cast in a frame, until all have been. 0: all at once.
  int receivers_at_rest = 1024;
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

struct ObjectInfluenceOptions {
  // Over each object's bounding sphere, low-discrepancy, where that fills more than 1/16 of a
  // surface's view; fewer in proportion where it fills less, down to an eighth. Converged: as many
  // as wished, up to 65536.
  int rays_per_receiver = 192;
  // On faces alone: how far apart receivers stand at least, as a share of the radius of the nearest
  // object's bounding sphere. Farther off it is a quarter of the distance to the object. Converged:
  // a tenth of that.
  double least_spacing = 0.06;
  // Receivers stand where the objects' bounding spheres fill more than this share of a surface's
  // view. Under a clear sun, eight times the sky, a white object adds half a code value to a shaded
  // surface there. Converged: a tenth of that.
  double least_share = 1.0 / 1024.0;
  // Blocks of pixels and spacing on faces are so many times as wide beside the distance to the
  // objects. Converged: a tenth.
  double coarseness = 1.0;
  InfluenceInMotionOptions in_motion{};
  // The options for objects in motion.
  ObjectInfluenceOptions InMotion() const;
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// Which parts of the influence are wanted.
struct InfluenceParts {
  bool hidden_light = true;  // Light of the sky and of real faces behind the objects.
  bool object_light = true;  // Light that the objects send instead.
};

// A unit of a basis light, as the scene has it.
struct InfluenceBasis {
  // Null for the sun, whose disc is not in it, and where `hidden_sky` is given.
  const SkyShape* sky = nullptr;
  // Radiosity of the faces of the real scene, and of the objects.
  std::span<const glm::vec3> real_radiosity;
  std::span<const glm::vec3> object_radiosity;
  // The sky's direct light that the objects hide at each of Receivers(), where that is known by
  // other means; else empty.
  std::span<const glm::vec3> hidden_sky = {};
};

// For one view and one pose of the objects: where rays from the real surfaces meet an object, and
// what they would meet without it,
//   change of irradiance = sum over rays of weight * pi * (L_object - L_behind).
// A ray that meets the real scene first changes nothing, so nothing darkens twice. Light between
// the surfaces that change is left out: real faces shine as without the objects.
//
// At pixels  each near an object has its own; farther off, blocks of up to 15 x 15 pixels share
//            one a plane, and pixels blend those around them. For that view alone.
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

  // The same before any rays are cast: for callers that spread them over several frames, by Cast.
  // What they get in the end is the same bit for bit.
  static ObjectInfluence InParts(const PatchScene& real,
                                 const PatchScene& objects,
                                 const SurfaceView& view,
                                 const ObjectInfluenceOptions& options);
  static ObjectInfluence InParts(const PatchScene& real,
                                 const PatchScene& objects,
                                 const ObjectInfluenceOptions& options);
  // Casts the rays of up to `receivers` more receivers (0: of all that lack them). Returns whether
  // all have been cast, as all other functions need.
  bool Cast(const PatchScene& real, const PatchScene& objects, int receivers);

  // On faces: what Evaluate is for. `faces` are those of `real`, as of construction, that the
  // pixels show, PatchScene::kSky where none.
  void See(const PatchScene& real, const SurfaceView& view, const Image<std::int32_t>& faces);

  std::size_t ReceiverCount() const { return receivers_.size(); }
  const std::vector<Receiver>& Receivers() const { return receivers_; }

  // Computes the response to a unit of basis light `light`: 0 is the sun, 1 + k the view's sky
  // shape k. `view` is that of construction, with its present responses; it is not used for
  // receivers on faces.
  // Throws std::invalid_argument where a number of faces or receivers, or the view's size, is
  // another.
  void Fold(std::size_t light, const InfluenceBasis& basis, const SurfaceView& view);

  // For callers that evaluate repeatedly: finds in advance where in the picture anything changes.
  // Evaluate then gives the same results in less time.
  void FindSpans();

  // On faces: whether Evaluate may change a pixel that shows a point of a side of `real`, in a
  // light whose sun and sky are to each other much as in `lighting`. Holds references to `real` and
  // to this.
  std::function<bool(std::int32_t side, const glm::vec3& point_m)> MayChange(
      const PatchScene& real, const Lighting& lighting, const InfluenceParts& parts) const;

  // The change under `lighting`, which has the sky components that were folded; 0 where it is less
  // than 1/512 of what the surface gets, a quarter of a code value in white. `change` keeps its
  // memory from frame to frame.
  // Throws  std::invalid_argument where `lighting` has other sky components than were folded.
  void Evaluate(const Lighting& lighting,
                const InfluenceParts& parts,
                IrradianceChange& change) const;

 private:
  struct Entry {
    std::uint32_t receiver;
    float weight;
  };
  // Pixels of a row that a receiver reaches.
  struct Span {
    std::uint32_t receiver;
    int begin_px;
    int end_px;
  };
  // The pixels of a row that can change.
  struct Row {
    int first_px = 0;
    std::vector<std::uint32_t> begin;  // Per pixel, entries [begin, next begin).
    std::vector<Entry> entries;
    std::vector<Span> spans;  // One a receiver; FindSpans makes them.

    int EndPx() const { return first_px + std::max(static_cast<int>(begin.size()) - 1, 0); }
    std::span<const Entry> EntriesOf(int x) const {
      const auto i = static_cast<std::size_t>(x - first_px);
      return std::span(entries).subspan(begin[i], begin[i + 1] - begin[i]);
    }
  };
  struct Response {
    glm::vec3 hidden{0.0f};
    glm::vec3 gained{0.0f};
    glm::vec3 before{0.0f};  // The surface's total irradiance.
  };

  void PlacePixels(const PatchScene& objects,
                   const SurfaceView& view,
                   const ObjectInfluenceOptions& options);
  glm::vec3 Before(std::size_t light,
                   std::size_t receiver,
                   const SurfaceView& view,
                   std::span<const glm::vec3> real_radiosity) const;
  // 0 where the change is less than `least` of what the surface gets.
  std::vector<glm::vec3> AtReceivers(const Lighting& lighting,
                                     const InfluenceParts& parts,
                                     float least) const;
  // The first pixel of a row that may change and the one after the last; the second is 0 if none.
  std::array<int, 2> PixelsThatChange(const Row& row,
                                      std::span<const glm::vec3> at_receivers) const;

  std::size_t real_faces_ = 0;
  std::size_t object_faces_ = 0;
  int picture_width_px_ = 0;
  int picture_height_px_ = 0;
  std::vector<Row> rows_;
  bool has_spans_ = false;
  std::vector<Receiver> receivers_;
  // Per receiver, the pixel where it stands; on faces a face that it stands on.
  std::vector<std::size_t> stands_at_;
  std::shared_ptr<InfluenceRays> rays_;         // Null without receivers.
  std::shared_ptr<const FaceLattice> lattice_;  // Null at pixels.
  std::vector<float> is_open_;              // On faces, per receiver: 0 inside an object, else 1.
  std::vector<glm::vec3> face_albedo_rgb_;  // On faces.
  std::vector<std::vector<Response>> responses_;  // Per basis light and receiver.
};

}  // namespace pleinair
