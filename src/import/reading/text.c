// SPDX-License-Identifier: MIT
#include "import/reading/text.h"

#include <assert.h>
#include <math.h>
#include <string.h>

bool stp_word_is(stp_text at, stp_text end, const char* word)
{
    assert(at <= end);
    for (; at < end && *word != '\0'; ++at, ++word) {
        unsigned char c = *at;
        c = c >= 'A' && c <= 'Z' ? (unsigned char)(c - 'A' + 'a') : c;
        if (c != (unsigned char)*word) {
            return false;
        }
    }
    return at == end && *word == '\0';
}

static const double powers_of_ten[] = {
    1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
    1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
};

// Large powers by squaring: each factor is off by at most half a unit in the last place.
static double scale_far(double value, int exponent)
{
    static const double squares[] = {1e16, 1e32, 1e64, 1e128, 1e256};
    unsigned rest = (unsigned)(exponent < 0 ? -exponent : exponent);
    assert(rest < 16u << (sizeof(squares) / sizeof(squares[0])) && "a bit per square");
    double low = powers_of_ten[rest % 16];
    value = exponent < 0 ? value / low : value * low;
    rest /= 16;
    for (int bit = 0; bit < 5; ++bit) {
        if ((rest >> bit & 1) != 0) {
            value = exponent < 0 ? value / squares[bit] : value * squares[bit];
        }
    }
    return value;
}

static double scale_decimal(uint64_t digits, int exponent)
{
    double value = (double)digits;
    if (exponent == 0 || digits == 0) {
        return value;
    }
    // both factors are exact, so the single operation rounds once (Clinger 1990)
    if (exponent > 0 && exponent <= 22) {
        return value * powers_of_ten[exponent];
    }
    if (exponent < 0 && exponent >= -22) {
        return value / powers_of_ten[-exponent];
    }
    if (exponent > 400) {
        return (double)INFINITY;
    }
    return exponent < -400 ? 0.0 : scale_far(value, exponent);
}

// "nan", "-nan(ind)", "inf", "infinity"; the sign was read before.
static stp_text read_special(stp_text at, bool negative, double* value)
{
    stp_text end = at;
    while ((*end | 0x20) >= 'a' && (*end | 0x20) <= 'z') {
        ++end;
    }
    if (stp_word_is(at, end, "nan")) {
        *value = (double)NAN;
        return *end == '(' ? stp_skip_word(end) : end;
    }
    if (stp_word_is(at, end, "inf") || stp_word_is(at, end, "infinity")) {
        *value = negative ? -(double)INFINITY : (double)INFINITY;
        return end;
    }
    return NULL;
}

static stp_text read_exponent(stp_text at, int* exponent)
{
    stp_text next = at + 1;
    bool negative = *next == '-';
    next += *next == '-' || *next == '+';
    if (!stp_is_digit(*next)) {
        return at; // the letter belongs to the next token
    }
    int sum = 0;
    for (; stp_is_digit(*next); ++next) {
        sum = sum < 10000 ? sum * 10 + (*next - '0') : sum;
    }
    *exponent += negative ? -sum : sum;
    return next;
}

stp_text stp_read_number(stp_text at, double* value)
{
    at = stp_skip_blanks(at);
    bool negative = *at == '-';
    at += *at == '-' || *at == '+';
    uint64_t digits = 0;
    int exponent = 0;
    stp_text start = at;
    unsigned digit;
    while ((digit = (unsigned)(*at - '0')) < 10) {
        digits = digits * 10 + digit;
        ++at;
    }
    stp_text point = at;
    if (*at == '.') {
        ++at;
        while ((digit = (unsigned)(*at - '0')) < 10) {
            digits = digits * 10 + digit;
            ++at;
        }
        exponent = (int)(point + 1 - at > -100000 ? point + 1 - at : -100000);
    }
    if (at - start <= (*point == '.')) {
        return read_special(start, negative, value);
    }
    if (at - start > 19) {
        // may exceed 64 bits: parse again, dropping digits after the 19th significant one
        digits = 0;
        int64_t dropped = 0, after_point = 0;
        for (stp_text p = start; p < at; ++p) {
            if (p == point) {
                continue;
            }
            after_point += p > point;
            if (digits < UINT64_C(1000000000000000000)) {
                digits = digits * 10 + (unsigned)(*p - '0');
            } else {
                dropped += 1;
            }
        }
        int64_t sum = dropped - after_point;
        exponent = (int)(sum < -100000 ? -100000 : sum > 100000 ? 100000 : sum);
    }
    assert(digits < UINT64_C(10000000000000000000) && "at most 19 digits are kept");
    if (*at == '#') {
        *value = (double)NAN; // 1.#IND, 1.#INF, 1.#QNAN
        return stp_skip_word(at);
    }
    if ((*at | 0x20) == 'e') {
        at = read_exponent(at, &exponent);
    }
    double magnitude = scale_decimal(digits, exponent);
    *value = negative ? -magnitude : magnitude;
    return at;
}

stp_text stp_read_integer(stp_text at, int64_t* value)
{
    at = stp_skip_blanks(at);
    bool negative = *at == '-';
    at += *at == '-' || *at == '+';
    if (!stp_is_digit(*at)) {
        return NULL;
    }
    int64_t sum = 0;
    for (; stp_is_digit(*at); ++at) {
        sum = sum > INT64_MAX / 10 - 1 ? INT64_MAX / 10 : sum * 10 + (*at - '0');
    }
    *value = negative ? -sum : sum;
    return at;
}

size_t stp_text_mark(stp_text bytes, size_t size)
{
    static const unsigned char mark[] = {0xef, 0xbb, 0xbf};
    const size_t head = size < 4096 ? size : 4096;
    bool marked = size >= sizeof(mark) && memcmp(bytes, mark, sizeof(mark)) == 0;
    return marked && memchr(bytes, 0, head) == NULL ? sizeof(mark) : 0;
}

void stp_text_end_lines(unsigned char* bytes, size_t size)
{
    for (size_t i = 0; i < size; ++i) {
        assert(bytes[i] != '\n' && "it has no line feeds");
        bytes[i] = bytes[i] == '\r' ? '\n' : bytes[i];
    }
}

size_t stp_whole_lines(stp_text bytes, size_t size)
{
    while (size > 0 && bytes[size - 1] != '\n') {
        size -= 1;
    }
    return size;
}

uint64_t stp_line_number(stp_text bytes, size_t offset)
{
    uint64_t line = 1;
    for (size_t at = 0; at < offset;) {
        const void* found = memchr(bytes + at, '\n', offset - at);
        if (found == NULL) {
            break;
        }
        at = (size_t)((stp_text)found - bytes) + 1;
        line += 1;
    }
    return line;
}
