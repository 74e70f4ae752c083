#include "calib/internal/exposed_pictures.h"

#include <cmath>
#include <stdexcept>
#include <string>

namespace pleinair {

void RequireSameView(std::span<const ExposedPicture> pictures) {
  if (pictures.empty()) throw std::invalid_argument("exposures: expected one picture or more");
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const ExposedPicture& picture = pictures[i];
    const std::string name = std::string("picture ") + std::to_string(i + 1);
    if (!(picture.exposure > 0.0) || !std::isfinite(picture.exposure)) {
      throw std::invalid_argument(name + ": exposure " + std::to_string(picture.exposure) +
                                  ": expected a positive number");
    }
    const Rgb8Image& first = pictures[0].codes;
    if (picture.codes.width != first.width || picture.codes.height != first.height) {
      throw std::invalid_argument(name + ": expected " + std::to_string(first.width) + "x" +
                                  std::to_string(first.height) + " pixels as in the first, found " +
                                  std::to_string(picture.codes.width) + "x" +
                                  std::to_string(picture.codes.height));
    }
  }
}

}  // namespace pleinair
