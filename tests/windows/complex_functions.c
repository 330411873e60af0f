/* The functions of complex numbers of C, which numpy calls and Wine's C runtime has not. */
#include <complex.h>

#define COMPLEX(name)                                             \
  double complex own_##name(double complex z) { return name(z); } \
  float complex own_##name##f(float complex z) { return name##f(z); }
#define REAL(name)                                        \
  double own_##name(double complex z) { return name(z); } \
  float own_##name##f(float complex z) { return name##f(z); }

COMPLEX(cacos)
COMPLEX(cacosh)
COMPLEX(casin)
COMPLEX(casinh)
COMPLEX(catan)
COMPLEX(catanh)
COMPLEX(ccos)
COMPLEX(ccosh)
COMPLEX(cexp)
COMPLEX(clog)
COMPLEX(conj)
COMPLEX(cproj)
COMPLEX(csin)
COMPLEX(csinh)
COMPLEX(csqrt)
COMPLEX(ctan)
COMPLEX(ctanh)
REAL(cabs)
REAL(carg)
REAL(cimag)
REAL(creal)

double complex own_cpow(double complex z, double complex w) { return cpow(z, w); }
float complex own_cpowf(float complex z, float complex w) { return cpowf(z, w); }
