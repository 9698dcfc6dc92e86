// Any springs, by owner, each with its pair's own contribution.
#pragma once

#include <cstddef>
#include <string>

#include "springs/form.hpp"
#include "springs/sum/slots.hpp"

namespace dvdx {

template <class T>
class PairsForm : public FormBase<T> {
 public:
  static constexpr SpringsAct act = SpringsAct::in_pair_sums;

  // The form refers to `columns`, which must live as long. Brown's methods treat each pair as if it were alone: W = k (w_a +
  // w_b). The owner has the share w / (w_a + w_b) of the pair's motion.
  PairsForm(const NetworkInput& in, Columns<T>& columns);

  void sum(const NetworkKernels<T>& passes, const WorkColumns<T>& work, std::size_t from, std::size_t to) const {
    passes.pairs(terms_, work, from, to);
  }

  [[nodiscard]] Edited edited() const noexcept { return Edited::never; }
  [[nodiscard]] std::string description() const { return "as a graph: each particle sums its pairs' own contributions"; }
  [[nodiscard]] std::size_t bytes() const noexcept { return lists_.bytes(); }

 private:
  GraphTerms<T> terms_;
  SlotLists lists_;
};

extern template class PairsForm<float>;
extern template class PairsForm<double>;

}  // namespace dvdx
