// Everything that the wide bodies use of xsimd and of instructions.
#pragma once

#include "simd/lane_numbers.hpp"
#include "simd/records.hpp"
#include "simd/registers.hpp"
#include "simd/threes.hpp"
