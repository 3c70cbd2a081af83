/* A picture in the light of its wall; what to subtract from a window, and what to add then, to paint it into it. */
#include "unit5.h"
#include "vectors.h"

#define RUN 64

/* The product of two shares of 255, rounded. */
static inline uint16_t product(uint16_t a, uint16_t b)
{
    uint16_t sum = a * b + 128;
    return (uint16_t)(sum + (sum >> 8)) >> 8;
}

/* At most RUN pixels; see unit5_mix_picture. */
FAST static void mix_run(const uint8_t *restrict window, const uint8_t *restrict picture, int channels,
                         const uint8_t *restrict mask, int length, uint16_t opacity, uint8_t *restrict hidden,
                         uint8_t *restrict shown)
{
    uint8_t colors[3 * RUN], alpha[3 * RUN];
    for (int x = 0; x < length; x++)
        for (int channel = 0; channel < 3; channel++) {
            colors[3 * x + channel] = picture[channels * x + channel];
            alpha[3 * x + channel] = channels == 4 ? picture[channels * x + 3] : 255;
        }
    for (int number = 0; number < 3 * length; number++) {
        uint16_t cover = product(product(mask[number], alpha[number]), opacity);
        hidden[number] = product(window[number], cover);
        shown[number] = product(colors[number], cover);
    }
}

void unit5_mix_picture(const Image *window, const Image *picture, const Image *mask, int opacity, uint8_t *hidden,
                       uint8_t *shown)
{
    for (int y = 0; y < window->height; y++)
        for (int left = 0; left < window->width; left += RUN) {
            int length = window->width - left < RUN ? window->width - left : RUN, channels = picture->channels;
            int64_t at = 3 * ((int64_t)window->width * y + left);
            mix_run(window->pixels + window->row * y + 3 * left, picture->pixels + picture->row * y + channels * left,
                    channels, mask->pixels + mask->row * y + 3 * left, length, opacity, hidden + at, shown + at);
        }
}

/* At most RUN pixels; see unit5_light_picture. */
FAST static void light_run(uint8_t *restrict picture, int channels, const uint8_t *restrict white, int length,
                           uint16_t black)
{
    uint8_t colors[3 * RUN];
    for (int x = 0; x < length; x++)
        for (int channel = 0; channel < 3; channel++)
            colors[3 * x + channel] = picture[channels * x + channel];
    for (int number = 0; number < 3 * length; number++)
        colors[number] = product(black + product(255 - black, colors[number]), white[number]);
    for (int x = 0; x < length; x++)
        for (int channel = 0; channel < 3; channel++)
            picture[channels * x + channel] = colors[3 * x + channel];
}

void unit5_light_picture(const Image *picture, const Image *white, int black)
{
    int channels = picture->channels;
    for (int y = 0; y < picture->height; y++)
        for (int left = 0; left < picture->width; left += RUN) {
            int length = picture->width - left < RUN ? picture->width - left : RUN;
            uint8_t *pixels = picture->pixels + picture->row * y + channels * left;
            const uint8_t *light = white->pixels + white->row * y + 3 * left;
            if (channels == 3)  /* compilers make faster code if they know the number */
                light_run(pixels, 3, light, length, black);
            else
                light_run(pixels, channels, light, length, black);
        }
}
