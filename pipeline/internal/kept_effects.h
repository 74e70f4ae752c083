// What objects do to real surfaces, mirror, and hide of the sun's disc: each with what it keeps
// from frame to frame, whether that still stands, and what its work costs.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "objects/frame_basis.h"
#include "objects/learned_cost.h"
#include "objects/mirror_image.h"
#include "objects/object_influence.h"
#include "objects/object_view.h"
#include "objects/soft_sun.h"
#include "objects/vertex_light.h"
#include "pipeline/frame_pipeline.h"

namespace pleinair {

// What a piece of work will cost.
struct WorkCost {
  double expected_ms = 0.0;  // As learned here.
  double nominal_ms = 0.0;   // The same everywhere.
  bool is_kept = false;
  // Of expected_ms, what later frames need not do again where nothing moves, and what they need not
  // before the sun has moved on.
  double once_ms = 0.0;
  double sun_ms = 0.0;
};

// What was never made, and what was made for an older sun.
struct LightCost {
  WorkCost lacking;
  WorkCost now;

  bool HasOlder() const { return now.nominal_ms > 0.0; }
  double NominalMs() const { return lacking.nominal_ms + now.nominal_ms; }
};

// The objects, pixel by pixel; for a view.
class KeptObjectView {
 public:
  void Forget() { version_.reset(); }
  WorkCost Cost(const SurfaceView& view) const;
  void Update(const PatchScene& objects, const SurfaceView& view);
  const ObjectView& View() const { return object_view_; }

 private:
  ObjectView object_view_;
  std::optional<std::uint64_t> version_;  // The view's, of its geometry.
  LearnedCost cost_{2.0};
};

// Shares of the sun's disc past objects; for a view and a sun. The two parts are made apart.
class KeptSunShares {
 public:
  void Forget() { real_version_ = object_version_ = std::nullopt; }
  WorkCost RealCost(const SurfaceView& view) const;
  WorkCost ObjectCost(const SurfaceView& view) const;
  void UpdateReal(const SoftSun& soft_sun, const SurfaceView& view, const DirectionalLight& sun);
  void UpdateObjects(const SoftSun& soft_sun,
                     const SurfaceView& view,
                     const ObjectView& objects,
                     const DirectionalLight& sun);
  const SunShares& Shares() const { return shares_; }

 private:
  SunShares shares_;
  std::optional<std::uint64_t> real_version_;    // The view's, of its sun.
  std::optional<std::uint64_t> object_version_;  // Likewise.
  LearnedCost real_cost_{4.0};
  LearnedCost object_cost_{4.0};
};

// What objects hide from real surfaces, and send them.
class KeptInfluence {
 public:
  explicit KeptInfluence(InfluenceAt at) : at_(at) {}
  void Forget() { geometry_version_.reset(); }
  // `light`: how the objects' light is to be found, of which the faces' radiosity is.
  WorkCost Cost(const SurfaceView& view,
                const FrameBasis& basis,
                const Lighting& lighting,
                VertexLight::Mode light) const;
  // Lights that shine in `lighting` have to have been worked out in `vertex_light`; of an older sun
  // they are made anew when that is.
  void Update(const PreparedScene& scene,
              const SurfaceView& view,
              const Image<std::int32_t>& pixel_faces,
              const FrameBasis& basis,
              const Lighting& lighting,
              const FramePipelineOptions& options,
              VertexLight& vertex_light);
  void Evaluate(const Lighting& lighting, const InfluenceParts& parts);
  const IrradianceChange& Change() const { return change_; }

 private:
  bool OnFaces() const { return at_ == InfluenceAt::kFaces; }
  // Whether rays have to be cast anew.
  bool IsNew(const SurfaceView& view, const FrameBasis& basis) const {
    return lights_ != basis.LightCount() || !geometry_version_ ||
           (!OnFaces() && geometry_version_ != view.geometry_version);
  }

  InfluenceAt at_;
  VertexLight::Mode light_;
  ObjectInfluence influence_;
  std::optional<std::uint64_t> geometry_version_;  // The view's.
  std::size_t lights_ = 0;
  LightsDone done_;
  std::vector<std::uint64_t> made_from_;  // By light: version of the objects' light.
  IrradianceChange change_;
  LearnedCost gather_cost_{150.0};
  LearnedCost see_cost_{4.0};
  LearnedCost light_cost_{2.0};
  LearnedCost sum_cost_{1.0};
};

// What glossy objects mirror.
class KeptMirror {
 public:
  void Forget() { geometry_version_.reset(); }
  LightCost Cost(const SurfaceView& view,
                 const FrameBasis& basis,
                 const Lighting& lighting,
                 VertexLight::Mode light) const;
  // As for KeptInfluence; `object_view` is the view's.
  void Update(const PreparedScene& scene,
              const SurfaceView& view,
              const ObjectView& object_view,
              const FrameBasis& basis,
              const Lighting& lighting,
              const MirrorImageOptions& options,
              Upto upto,
              VertexLight& vertex_light);
  void Evaluate(const Lighting& lighting);
  const MirroredLight& Image() const { return image_; }
  const LightsDone& Done() const { return done_; }

 private:
  bool IsNew(const SurfaceView& view, const FrameBasis& basis) const {
    return lights_ != basis.LightCount() || geometry_version_ != view.geometry_version;
  }

  VertexLight::Mode light_;
  MirrorImage mirror_;
  std::optional<std::uint64_t> geometry_version_;  // The view's.
  std::size_t lights_ = 0;
  LightsDone done_;
  std::vector<std::uint64_t> made_from_;  // By light: version of the objects' light.
  MirroredLight image_;
  LearnedCost gather_cost_{60.0};
  LearnedCost light_cost_{8.0};
  LearnedCost sum_cost_{0.5};
};

}  // namespace pleinair
