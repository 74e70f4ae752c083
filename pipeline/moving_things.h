// What moves in front of a fixed camera: cars, people, plants in the wind, reflections in windows.
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

struct MovingThingsOptions {
  // Natural log of a radiance's ratio to what the model predicts, beyond what is usual of the
  // pixel: from here on something else is seen. > 0.
  double least_change = 0.3;
  // Of the frames that show the surface, in [0, 1]; and that many of them at least, >= 1. What
  // hides it less often is left to the fit, which is robust.
  double least_share = 0.02;
  int least_frames = 2;
  // Pixels are looked at in blocks, so that there are at most so many. >= 1.
  int most_blocks = 40000;
  // Throws std::invalid_argument naming field and value.
  void Validate() const;
};

struct MovingThingsFound {
  // Over the picture: 255 where nothing moves or nothing is known, 0 where it does, with a margin
  // of a block. Empty without frames.
  Gray8Image mask;
  // Share of the frames in which a pixel's surface was not seen, [0, 1]; 0 where nothing is known.
  Image<float> hidden_share;
  int frames = 0;
  // A class of light is what one group of the mesh shows to one side, in sun or in shade.
  double typical_change = 0.0;  // Median over blocks of the spread over frames, in log.
  struct Region {
    std::string name;
    std::int64_t pixels = 0;  // That may be sampled.
    std::int64_t masked = 0;  // Of them.
  };
  std::vector<Region> regions;  // In the view's order; those with pixels.
};

// Per block and frame, the log of what the camera saw over what the model predicts under the
// frame's own estimated light. A block's median over the frames is its own (an albedo that is wrong
// stays wrong), a median over the blocks of one class of light is the frame's (light that is
// estimated wrongly is so for all of them). What is left beyond `least_change`, in three by three
// blocks at once, hides the surface.
//
// Shadows   Where the mesh may be wrong about sun and shade, any share of the sun is as expected;
//           next to edges of the model nothing is looked at. A shadow that the mesh lacks and that
//           stands for more than half of the time is the surface's own, and sun on it something
//           else.
// Not seen  Grey things between the lit and the shaded surface in brightness, on which the sun
//           shines in the model's opinion or which it could.
class MovingThings {
 public:
  explicit MovingThings(const MovingThingsOptions& options = {});

  // `view` and `lighting` are the frame's. Returns false, and adds nothing, for a frame of another
  // camera, or camera pose, than the first one's. Memory: 40 bytes a block.
  bool Add(const Frame& frame, const SurfaceView& view, const Lighting& lighting);

  MovingThingsFound Find() const;

 private:
  // Of a block in a frame, per channel, in log.
  struct Seen {
    glm::vec3 ratio{0.0f};          // Of the camera's radiance to the model's.
    glm::vec3 lit{0.0f};            // Of the model's, with all of the sun's disc seen, to itself.
    glm::vec3 shaded{0.0f};         // With none.
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
  Image<std::int32_t> region_;          // Of the first frame's view,
  Image<std::uint8_t> may_be_sampled_;  // and in any frame.
};

}  // namespace pleinair
