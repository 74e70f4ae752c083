// Finds what moves in front of a fixed camera: cars, people, plants in the wind, reflections in
// windows.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/camera.h"
#include "scene/frame.h"
#include "scene/image.h"
#include "scene/lighting.h"
#include "scene/surface_view.h"

namespace pleinair {

// Thresholds of the search.
struct MovingThingsOptions {
  // Natural log of the ratio of radiance to the model's prediction, relative to the pixel's usual
  // ratio. From this value on, the pixel shows something else. > 0.
  double least_change = 0.3;
  // Least share, in [0, 1], of the frames that show the surface, and least number, >= 1, in which
  // it is hidden. What hides it less often is left to the fit, which is robust.
  double least_share = 0.02;
  int least_frames = 2;
  // Pixels are grouped in blocks, of which there are at most this many. >= 1.
  int most_blocks = 40000;
  // Throws std::invalid_argument naming field and value.
  void Validate() const;
};

// What was found over all frames.
struct MovingThingsFound {
  // Over the picture: 0 where something moves, with a margin of a block; 255 elsewhere and where
  // nothing is known. Empty without frames.
  Gray8Image mask;
  // Share of the frames in which a pixel's surface was not visible, [0, 1]; 0 where nothing is
  // known.
  Image<float> hidden_share;
  int frames = 0;
  // A class of light is one group of the mesh with one facing, in sun or in shade.
  double typical_change = 0.0;  // Median over blocks of the spread over frames, in log.
  struct Region {
    std::string name;
    std::int64_t pixels = 0;  // Pixels that may be sampled.
    std::int64_t masked = 0;  // How many of those pixels are masked.
  };
  std::vector<Region> regions;  // In the view's order; those with pixels.
};

// For each block and frame it computes the log of the camera's radiance over the model's prediction
// under the frame's own estimated light. The block's median over the frames is subtracted (the
// error of an albedo is constant). So is the frame's median over the blocks of one class of light
// (the error of the light is common to them). Where the rest is beyond `least_change`, in three by
// three blocks at once, something hides the surface.
//
// Shadows   Where the mesh may be wrong about sun and shade, any share of the sun is accepted;
//           blocks next to edges of the model are not used. A shadow that the mesh lacks and that
//           stays for more than half of the time counts as the surface's own, and sun on it as
//           something else.
// Not seen Grey things with a brightness between the lit and the shaded surface, where the model
// has the sun, or may have it.
class MovingThings {
 public:
  explicit MovingThings(const MovingThingsOptions& options = {});

  // `view` and `lighting` are the frame's. Returns false, and adds nothing, for a frame of another
  // camera, or camera pose, than the first one's. Memory: 40 bytes for each block.
  bool Add(const Frame& frame, const SurfaceView& view, const Lighting& lighting);

  MovingThingsFound Find() const;

 private:
  // One block in one frame, per channel, in log.
  struct Seen {
    glm::vec3 ratio{0.0f};  // The camera's radiance over the model's.
    // The model's radiance with all of the sun's disc visible, over the model's.
    glm::vec3 lit{0.0f};
    glm::vec3 shaded{0.0f};         // The same with none of it.
    std::int32_t light_class = -1;  // -1: the block was not seen.
  };
  struct SeenFrame {
    std::vector<Seen> blocks;
    std::int32_t classes = 0;
  };
  using Changes = std::vector<std::vector<glm::vec3>>;  // Per frame and block.

  std::optional<Seen> SeeBlock(const Frame& frame,
                               const SurfaceView& view,
                               const Lighting& lighting,
                               int column,
                               int row) const;
  Changes UnusualChanges() const;

  MovingThingsOptions options_;
  Camera camera_;
  int block_px_ = 1;
  int columns_ = 0;
  int rows_ = 0;
  std::vector<SeenFrame> frames_;
  std::vector<std::string> region_names_;
  Image<std::int32_t> region_;          // In the first frame's view,
  Image<std::uint8_t> may_be_sampled_;  // and in any frame.
};

}  // namespace pleinair
