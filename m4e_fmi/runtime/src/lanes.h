/* The interpreter on lanes, included once for each instruction set: M4E_NAME is the function's
   name, M4E_TARGETED its attribute. Operands and result are the same register or apart. */
M4E_TARGETED static void M4E_NAME(const instruction *code, double *r) {
    M4E_RUN {
        M4E_UNARY(M4E_RUN1)
        M4E_BINARY(M4E_RUN2)
        M4E_FUSED(M4E_RUN3)
        M4E_CHAINED(M4E_RUN5)
        M4E_PAIRED(M4E_RUN4)
        M4E_CASE(SINCOS) {
            double s[M4E_LANES], c[M4E_LANES];
            el_sincos_many(M4E_LANES, r + (size_t)code->a * M4E_LANES, s, c);
            memcpy(r + (size_t)code->b * M4E_LANES, s, sizeof s);
            memcpy(r + (size_t)code->d * M4E_LANES, c, sizeof c);
            M4E_SKIP(1)
        }
        M4E_CASE(END) return;
    }
}
#undef M4E_NAME
#undef M4E_TARGETED
