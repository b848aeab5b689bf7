// zfp's compressed arrays of 3-D floats, multiplied element by element: see zfp_multiply.h.
#include "zfp_multiply.h"

#include <vector>

#include <zfp/array3.hpp>

struct zfp_pair {
    zfp::array3f a, b, c;
    std::vector<float> dense_a, dense_b;
    zfp_pair(const float *p, const float *q, const size_t n[3], double rate)
        : a(n[0], n[1], n[2], rate, p), b(n[0], n[1], n[2], rate, q), c(n[0], n[1], n[2], rate),
          dense_a(n[0] * n[1] * n[2]), dense_b(dense_a)
    {
    }
};

zfp_pair *zfp_pair_make(const float *a, const float *b, const size_t dims[3], double rate)
{
    return new zfp_pair(a, b, dims, rate);
}

double zfp_pair_rate(const zfp_pair *pair)
{
    return pair->a.rate();
}

static void by_iterators(zfp_pair &p)
{
    zfp::array3f::const_iterator a = p.a.cbegin(), b = p.b.cbegin();
    for (zfp::array3f::iterator c = p.c.begin(); c != p.c.end(); ++c, ++a, ++b)
        *c = *a * *b;
}

static void by_indices(zfp_pair &p)
{
    for (size_t k = 0; k < p.c.size_z(); k++)
        for (size_t j = 0; j < p.c.size_y(); j++)
            for (size_t i = 0; i < p.c.size_x(); i++)
                p.c(i, j, k) = p.a(i, j, k) * p.b(i, j, k);
}

static void by_dense(zfp_pair &p)
{
    p.a.get(p.dense_a.data());
    p.b.get(p.dense_b.data());
    for (size_t i = 0; i < p.dense_a.size(); i++)
        p.dense_a[i] *= p.dense_b[i];
    p.c.set(p.dense_a.data());
}

void zfp_pair_multiply(zfp_pair *pair, int way)
{
    pair->a.clear_cache();
    pair->b.clear_cache();
    if (way == ZFP_ITERATORS)
        by_iterators(*pair);
    else if (way == ZFP_INDICES)
        by_indices(*pair);
    else
        by_dense(*pair);
    pair->c.flush_cache();
}

void zfp_pair_result(zfp_pair *pair, float *out)
{
    pair->c.get(out);
}

void zfp_pair_free(zfp_pair *pair)
{
    delete pair;
}
