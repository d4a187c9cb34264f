"""C++ functions shared by all headers: serialization of numbers and texts."""

#: Its place among the headers.
WIRE_PATH = "serial_link/wire.h"

#: The boards that rosserial supports keep the lowest byte first, as the wire does; so numbers are
#: copied. What a board calls double may have 4 bytes only, so 64 bits are made of a float's 32:
#: sign, exponent with a bias of 1023 in place of 127, fraction (IEEE 754).
WIRE_HEADER = """\
// Numbers and texts as bytes, and back. Made by serial_link's make_headers.
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

// What a field of 64 bits is on the board: many have no double of 8 bytes.
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
  } else if (fraction > 0) {  // so small that its fraction starts with zeros
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

// 64 bits as a float: what is too large is infinite, what is too small 0.
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
    // To the nearest; a carry goes into the exponent, as it has to.
    bits = (narrow > 0 ? (uint32_t)(narrow - 1) << 23 : 0) +
           (uint32_t)((whole + ((uint64_t)1 << (lost - 1)) - 1 + ((whole >> lost) & 1)) >> lost);
    if (narrow >= 0xff || bits > 0x7f800000) bits = 0x7f800000;
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

// The text stays where it came; it moves one byte down, so that there is room for its end.
inline int get_text(unsigned char *in, const char *&text) {
  uint32_t length;
  get(in, length);
  memmove(in + 3, in + 4, length);
  in[3 + length] = 0;
  text = (const char *)(in + 3);
  return 4 + length;
}

// Makes room for the elements that come. What was received before is used again, as it may have
// room of its own; what the sketch has put there is left alone.
template <typename Element>
inline int get_length(
    const unsigned char *in, uint32_t &length, uint32_t &room, Element *&elements) {
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
