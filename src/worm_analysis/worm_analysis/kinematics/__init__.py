"""The paper's symbols as functions of positions: r, θ, ψ, θ̇."""
