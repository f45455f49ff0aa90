#include "solver/single_factor.hpp"

#include <algorithm>
#include <atomic>

#include "core/instruction_set.hpp"
#include "core/parallel.hpp"

namespace glossa {
namespace {

constexpr Index panel = 128;  // columns of a wide supernode that are eliminated at once

std::size_t size(Index n) {
  return static_cast<std::size_t>(n);
}

}  // namespace

SingleFactor::SingleFactor(SupernodalLayout layout)
    : layout_(std::move(layout)),
      values_(layout_.value_count, 0.0f),
      work_(2 * size(layout_.longest), 0.0f),
      updates_(layout_.supernodes.size()) {}

bool SingleFactor::factorise(const LowerColumns& matrix, int threads, float share) {
  for (auto& update : updates_)
    if (update) give_back(std::move(update));  // left by a factorisation that failed
  std::atomic<bool> failed = false;
  parallel_items(static_cast<int>(layout_.branches.size()), threads, [&](int branch) {
    for (const Index k : layout_.branches[static_cast<std::size_t>(branch)]) {
      if (failed) break;
      if (!eliminate(k, matrix, 1, share)) failed = true;
    }
  });
  if (failed) return false;
  return std::all_of(layout_.trunk.begin(), layout_.trunk.end(),
                     [&](Index k) { return eliminate(k, matrix, threads, share); });
}

bool SingleFactor::eliminate(Index k, const LowerColumns& matrix, int threads, float share) {
  const Supernode& s = layout_.supernodes[size(k)];
  std::fill(values_.begin() + static_cast<std::ptrdiff_t>(s.diagonal),
            values_.begin() + static_cast<std::ptrdiff_t>(s.off + size(s.columns) * size(s.padded_below)), 0.0f);
  const Index last = matrix.column_start[size(s.first + s.columns)];
  for (Index e = matrix.column_start[size(s.first)]; e < last; ++e)
    values_[layout_.entry[size(e)]] = static_cast<float>(matrix.value[size(e)]);
  for (Index j = 0; j < s.columns; ++j) *diagonal(s, j, j).data *= 1.0f + share;
  for (const Index* c = layout_.children.begin(k); c != layout_.children.end(k); ++c) add_to_columns(*c, s);
  if (!factorise_columns(s, threads)) return false;
  if (s.below > 0) {
    std::unique_ptr<Update>& update = updates_[size(k)];
    update = take(size(s.below) * size(s.below));
    subtract_square(off(s, 0), s.below, s.columns, {update->data(), s.below}, 0.0f, threads);
  }
  for (const Index* c = layout_.children.begin(k); c != layout_.children.end(k); ++c) {
    if (s.below > 0) add_to_update(*c, s, *updates_[size(k)]);
    give_back(std::move(updates_[size(*c)]));
  }
  return true;
}

bool SingleFactor::factorise_columns(const Supernode& s, int threads) {
  for (Index j = 0; j < s.columns; j += panel) {
    const Index n = std::min(panel, s.columns - j), next = j + n, rest = s.columns - next;
    const Block triangle = diagonal(s, j, j), beside = diagonal(s, next, j);
    if (!factorise_dense(triangle, n)) return false;
    divide_dense(triangle, n, beside, rest, threads);
    divide_dense(triangle, n, off(s, j), s.below, threads);
    subtract_square(beside, rest, n, diagonal(s, next, next), 1.0f, threads);
    subtract_product(off(s, j), s.below, beside, rest, n, off(s, next), threads);
  }
  for (Index j = 0; j < s.columns; ++j) *diagonal(s, j, j).data = 1.0f / *diagonal(s, j, j).data;
  return true;
}

void SingleFactor::add_to_columns(Index child, const Supernode& s) {
  const Index n = layout_.supernodes[size(child)].below, split = layout_.passed_columns[size(child)];
  const Index* place = layout_.place_in_next.data() + layout_.supernodes[size(child)].row_start;
  const float* from = updates_[size(child)]->data();
  for (Index j = 0; j < split; ++j, from += n) {
    float* in_diagonal = diagonal(s, 0, place[j]).data;
    float* in_off = off(s, place[j]).data;
    for (Index i = j; i < split; ++i) in_diagonal[place[i]] += from[i];
    for (Index i = split; i < n; ++i) in_off[place[i] - s.columns] += from[i];
  }
}

void SingleFactor::add_to_update(Index child, const Supernode& s, Update& update) const {
  const Index n = layout_.supernodes[size(child)].below, split = layout_.passed_columns[size(child)];
  const Index* place = layout_.place_in_next.data() + layout_.supernodes[size(child)].row_start;
  const float* from = updates_[size(child)]->data() + size(split) * size(n);
  for (Index j = split; j < n; ++j, from += n) {
    float* to = update.data() + size(place[j] - s.columns) * size(s.below);
    for (Index i = j; i < n; ++i) to[place[i] - s.columns] += from[i];
  }
}

std::unique_ptr<SingleFactor::Update> SingleFactor::take(std::size_t wanted) {
  std::unique_ptr<Update> found;
  {
    const std::lock_guard<std::mutex> lock(pool_->mutex);
    auto best = pool_->free.end();
    for (auto it = pool_->free.begin(); it != pool_->free.end(); ++it)
      if ((*it)->size() >= wanted && (best == pool_->free.end() || (*it)->size() < (*best)->size())) best = it;
    if (best == pool_->free.end() && !pool_->free.empty()) --best;  // grows
    if (best != pool_->free.end()) {
      found = std::move(*best);
      pool_->free.erase(best);
    }
  }
  if (!found) found = std::make_unique<Update>();
  if (found->size() < wanted) *found = Update(wanted);
  return found;
}

void SingleFactor::give_back(std::unique_ptr<Update> update) {
  const std::lock_guard<std::mutex> lock(pool_->mutex);
  pool_->free.push_back(std::move(update));
}

void SingleFactor::copy(const Index* value_start, const double* values) {
  for (std::size_t k = 0; k < layout_.supernodes.size(); ++k) {
    const Supernode& s = layout_.supernodes[k];
    const Index lead = s.columns + s.below;
    for (Index j = 0; j < s.columns; ++j) {
      const double* from = values + value_start[k] + static_cast<std::ptrdiff_t>(j) * lead;
      float *block = diagonal(s, 0, j).data, *below = off(s, j).data;
      std::fill(block, block + s.padded_columns, 0.0f);
      block[j] = static_cast<float>(1.0 / from[j]);
      for (Index i = j + 1; i < s.columns; ++i) block[i] = static_cast<float>(from[i]);
      for (Index i = 0; i < s.below; ++i) below[i] = static_cast<float>(from[s.columns + i]);
    }
  }
}

void SingleFactor::solve(Vector& x) {
  // Scaled, so that neither tiny residuals nor large loads leave the range of single precision.
  const double largest = x.size() > 0 ? x.cwiseAbs().maxCoeff() : 0.0;
  if (!(largest > 0.0)) return;
  x_.resize(static_cast<std::size_t>(x.size()));
  for (std::size_t k = 0; k < x_.size(); ++k) x_[k] = static_cast<float>(x(static_cast<Eigen::Index>(k)) / largest);
  const SingleFactorView view{
      layout_.supernodes.data(),      layout_.supernodes.size(), layout_.rows.data(), values_.data(), work_.data(),
      work_.data() + work_.size() / 2};
#ifdef GLOSSA_HAS_AVX2_KERNEL
  if (has_avx2())
    avx2::solve_single(view, x_.data());
  else
#endif
    baseline::solve_single(view, x_.data());
  for (std::size_t k = 0; k < x_.size(); ++k) x(static_cast<Eigen::Index>(k)) = largest * static_cast<double>(x_[k]);
}

}  // namespace glossa
