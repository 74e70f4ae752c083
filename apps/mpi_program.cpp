// `pleinair-mpi`: the same commands for jobs that several processes share, as
//   mpirun -n 4 pleinair-mpi irradiance ...
// A program of its own, because loading MPI takes longer than many a command.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <mpi.h>

#include "apps/command_line.h"
#include "apps/shared_ranks.h"

namespace {

// MPI counts in int.
constexpr std::uint64_t kMostBytesAtOnce = std::uint64_t{1} << 30;

// Any failure of MPI ends the job: the default error handler of its world.
class MpiRanks : public pleinair::RankGroup {
 public:
  MpiRanks() {
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &count_);
  }
  std::size_t Rank() const override { return static_cast<std::size_t>(rank_); }
  std::size_t Count() const override { return static_cast<std::size_t>(count_); }

  std::vector<std::byte> Join(std::span<const std::byte> mine) override {
    std::vector<std::byte> all;
    for (int rank = 0; rank < count_; ++rank) {
      std::uint64_t size = mine.size();
      MPI_Bcast(&size, 1, MPI_UINT64_T, rank, MPI_COMM_WORLD);
      const std::size_t begin = all.size();
      all.resize(begin + size);
      if (rank == rank_) {
        std::copy(mine.begin(), mine.end(), all.begin() + static_cast<std::ptrdiff_t>(begin));
      }
      for (std::uint64_t sent = 0; sent < size; sent += kMostBytesAtOnce) {
        const auto bytes = static_cast<int>(std::min(size - sent, kMostBytesAtOnce));
        MPI_Bcast(all.data() + begin + sent, bytes, MPI_BYTE, rank, MPI_COMM_WORLD);
      }
    }
    return all;
  }

 private:
  int rank_ = 0;
  int count_ = 1;
};

}  // namespace

int main(int argc, char** argv) {
  int provided = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
  int code = 0;
  {
    MpiRanks ranks;
    pleinair::SetSharedRanks(&ranks);
    code = pleinair::RunCommandLine(argc, argv);
    if (code != 0) MPI_Abort(MPI_COMM_WORLD, code);  // Others may be waiting for this rank.
  }
  MPI_Finalize();
  return code;
}
