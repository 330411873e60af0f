// Made by tests/support/elementary_coefficients.py, which says how. Do not edit.
// clang-format off
#pragma once

#include <cstdint>

namespace robsim::elementary {

// pi/2 in parts of 33 bits: their products with an integer of 20 bits are exact.
constexpr double pi_2_parts[] = {
    0x1.921fb54400000p+0,
    0x1.0b4611a600000p-34,
    0x1.3198a2e000000p-69,
    0x1.b839a252049c1p-104,
};
constexpr double two_over_pi = 0x1.45f306dc9c883p-1;

// As the double next to it and the rest.
constexpr double pi_2[] = {
    0x1.921fb54442d18p+0,
    0x1.1a62633145c07p-54,
};
constexpr double pi_[] = {
    0x1.921fb54442d18p+1,
    0x1.1a62633145c07p-53,
};

// The binary digits of 2/pi, 32 in a word, from the 64th place before the point on.
constexpr std::uint32_t two_over_pi_words[] = {
    0x00000000,
    0x00000000,
    0xa2f9836e,
    0x4e441529,
    0xfc2757d1,
    0xf534ddc0,
    0xdb629599,
    0x3c439041,
    0xfe5163ab,
    0xdebbc561,
    0xb7246e3a,
    0x424dd2e0,
    0x06492eea,
    0x09d1921c,
    0xfe1deb1c,
    0xb129a73e,
    0xe88235f5,
    0x2ebb4484,
    0xe99c7026,
    0xb45f7e41,
    0x3991d639,
    0x835339f4,
    0x9c845f8b,
    0xbdf9283b,
    0x1ff897ff,
    0xde05980f,
    0xef2f118b,
    0x5a0a6d1f,
    0x6d367ecf,
    0x27cb09b7,
    0x4f463f66,
    0x9e5fea2d,
    0x7527bac7,
    0xebe5f17b,
    0x3d0739f7,
    0x8a5292ea,
    0x6bfb5fb1,
    0x1f8d5d08,
    0x56033046,
    0xfc7b6bab,
};

// (sin(r)/r - 1)/r^2 and (cos(r) - 1 + r^2/2)/r^4 in r^2, |r| <= pi/4.
constexpr double sine_part[] = {
    -0x1.5555555555555p-3,
    0x1.1111111110bb2p-7,
    -0x1.a01a019e83aaep-13,
    0x1.71de37968a100p-19,
    -0x1.ae600b02b6262p-26,
    0x1.5e0b19f8b1451p-33,
};
constexpr double cosine_part[] = {
    0x1.5555555555555p-5,
    -0x1.6c16c16c16967p-10,
    0x1.a01a019f4eb01p-16,
    -0x1.27e4fa17da09ep-22,
    0x1.1eeb68e93b64cp-29,
    -0x1.907da367a37cbp-37,
};

// atan(k/16), as the double next to it and the rest.
constexpr double angle[] = {
    0x0.0p+0,
    0x1.ff55bb72cfdeap-5,
    0x1.fd5ba9aac2f6ep-4,
    0x1.7b97b4bce5b02p-3,
    0x1.f5b75f92c80ddp-3,
    0x1.362773707ebccp-2,
    0x1.6f61941e4def1p-2,
    0x1.a64eec3cc23fdp-2,
    0x1.dac670561bb4fp-2,
    0x1.0657e94db30d0p-1,
    0x1.1e00babdefeb4p-1,
    0x1.345f01cce37bbp-1,
    0x1.4978fa3269ee1p-1,
    0x1.5d58987169b18p-1,
    0x1.700a7c5784634p-1,
    0x1.819d0b7158a4dp-1,
    0x1.921fb54442d18p-1,
};
constexpr double angle_rest[] = {
    0x0.0p+0,
    -0x1.c934d86d23f1dp-60,
    -0x1.cd37686760c17p-59,
    0x1.347b0b4f881cap-58,
    0x1.8ab6e3cf7afbdp-57,
    -0x1.963a544b672d8p-57,
    -0x1.c63aae6f6e918p-56,
    -0x1.24dec1b50b7ffp-56,
    0x1.a2b7f222f65e2p-56,
    -0x1.d5b495f6349e6p-56,
    -0x1.928df287a668fp-58,
    0x1.1021137c71102p-55,
    0x1.2419a87f2a458p-56,
    0x1.0028e4bc5e7cap-57,
    -0x1.8c34d25aadef6p-56,
    -0x1.bf76229d3b917p-56,
    0x1.1a62633145c07p-55,
};

// (atan(r)/r - 1)/r^2 in r^2, |r| <= 1/32.
constexpr double arc_tangent_part[] = {
    -0x1.5555555555555p-2,
    0x1.999999999988cp-3,
    -0x1.2492492282c2dp-3,
    0x1.c71c44b12f1f2p-4,
    -0x1.7393b9af45e23p-4,
};

// log 2: a part of 32 bits, whose products with exponents are exact, and the rest.
constexpr double log_2_parts[] = {
    0x1.62e42fee00000p-1,
    0x1.a39ef35793c76p-33,
};
constexpr double one_over_log_2 = 0x1.71547652b82fep+0;

// (exp(r) - 1 - r)/r^2 in r, |r| <= log(2)/2.
constexpr double exponential_part[] = {
    0x1.0000000000001p-1,
    0x1.5555555555556p-3,
    0x1.5555555553d68p-5,
    0x1.11111111109b5p-7,
    0x1.6c16c17889ef1p-10,
    0x1.a01a01a7c2efep-13,
    0x1.a019b9149a41cp-16,
    0x1.71de0db2f6b19p-19,
    0x1.28917c89a43a7p-22,
    0x1.af389ecfc4b9cp-26,
};

// (log((1 + s)/(1 - s))/s - 2)/s^2 in s^2, 1/sqrt(2) <= (1 + s)/(1 - s) <= sqrt(2).
constexpr double logarithm_part[] = {
    0x1.5555555555558p-1,
    0x1.99999999952e2p-2,
    0x1.2492492df148dp-2,
    0x1.c71c62e5800a1p-3,
    0x1.7462b4ab2ef6bp-3,
    0x1.39fe606542ddep-3,
    0x1.2b584aae78a57p-3,
};

}  // namespace robsim::elementary
