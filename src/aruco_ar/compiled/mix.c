/* What to subtract from a window, and what to add then, to paint a picture into it. */
#include "shares.h"
#include "unit5.h"
#include "vectors.h"

#define RUN 64

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
