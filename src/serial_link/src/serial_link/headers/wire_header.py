"""Text of the C++ header wire.h: serialization for all generated headers."""

#: Path of this header among the generated ones.
WIRE_PATH = "serial_link/wire.h"

#: The boards that rosserial supports are little-endian, like the wire format: numbers are copied.
#: A board's double may have only 4 bytes, so 64 bits are made from a 32-bit float: sign, exponent
#: with a bias of 1023 instead of 127, fraction (IEEE 754).
WIRE_HEADER = """\
// Serialization of numbers and strings. Made by serial_link's make_headers.
#ifndef SERIAL_LINK_WIRE_H
#define SERIAL_LINK_WIRE_H

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

namespace serial_link {

template <typename Number> inline int put(unsigned char *out, Number value) {
  memcpy(out, &value, sizeof(value));
  return sizeof(value);
}

template <typename Number> inline int get(const unsigned char *in, Number &value) {
  memcpy(&value, in, sizeof(value));
  return sizeof(value);
}

inline int get(const unsigned char *in, bool &value) {
  value = in[0] != 0;
  return 1;
}

// Type of a float64 field on the board: many boards have no 8-byte double.
#if __SIZEOF_DOUBLE__ == 8
typedef double float64;
inline int put64(unsigned char *out, double value) { return put(out, value); }
inline int get64(const unsigned char *in, double &value) { return get(in, value); }
#else
typedef float float64;
#endif

// A float as 64 bits.
inline int put64(unsigned char *out, float value) {
  uint32_t bits;
  memcpy(&bits, &value, 4);
  int16_t exponent = (bits >> 23) & 0xff;
  uint32_t fraction = bits & 0x7fffff;
  if (exponent == 0xff) {  // infinite, or not a number
    exponent = 0x7ff;
  } else if (exponent > 0) {
    exponent += 1023 - 127;
  } else if (fraction > 0) {  // subnormal
    exponent = 1023 - 126;
    while (!(fraction & 0x800000)) {
      fraction <<= 1;
      exponent--;
    }
    fraction &= 0x7fffff;
  }
  uint64_t sign = bits >> 31;
  uint64_t wide = sign << 63 | (uint64_t)exponent << 52 | (uint64_t)fraction << 29;
  return put(out, wide);
}

// 64 bits as a float: too large becomes infinite, too small 0.
inline int get64(const unsigned char *in, float &value) {
  uint64_t wide;
  get(in, wide);
  int16_t exponent = (wide >> 52) & 0x7ff;
  uint64_t fraction = wide & 0xfffffffffffffULL;
  uint32_t bits = 0;
  if (exponent == 0x7ff) {
    bits = 0x7f800000 | (fraction ? 0x400000 : 0);
  } else if (exponent > 1023 - 150) {
    uint64_t whole = fraction | 0x10000000000000ULL;
    int16_t narrow = exponent - 1023 + 127;
    int16_t lost = narrow > 0 ? 29 : 30 - narrow;
    // Round to nearest; a carry correctly goes into the exponent.
    bits = (narrow > 0 ? (uint32_t)(narrow - 1) << 23 : 0) +
           (uint32_t)((whole + ((uint64_t)1 << (lost - 1)) - 1 + ((whole >> lost) & 1)) >> lost);
    if (narrow >= 0xff) bits = 0x7f800000;
  }
  bits |= (uint32_t)(wide >> 63) << 31;
  memcpy(&value, &bits, 4);
  return 8;
}

inline int put_text(unsigned char *out, const char *text) {
  uint32_t length = text ? strlen(text) : 0;
  put(out, length);
  memcpy(out + 4, text, length);
  return 4 + length;
}

// The string stays in the buffer; it moves down by one byte, to make room for its terminator.
template <typename Text> inline int get_text(unsigned char *in, Text *&text) {
  uint32_t length;
  get(in, length);
  memmove(in + 3, in + 4, length);
  in[3 + length] = 0;
  text = (Text *)(in + 3);
  return 4 + length;
}

// Makes room for the received elements. Elements of an earlier message are reused, because they may
// own memory; values that the sketch has stored there are kept.
template <typename Element>
inline int get_length(
    const unsigned char *in, uint32_t &length, size_t &room, Element *&elements) {
  get(in, length);
  if (length > room) {
    elements = (Element *)realloc(room ? (void *)elements : NULL, length * sizeof(Element));
    Element blank = Element();
    for (uint32_t i = room; i < length; i++) memcpy((void *)(elements + i), &blank, sizeof(blank));
    room = length;
  }
  return 4;
}

}  // namespace serial_link

#endif
"""
